#pragma once

#include <map>
#include <mutex>

#include "services/bus/fastdds/rtps_check.hpp"

namespace tonus::bus {

/// Finds remote readers that have forgotten this participant, and has its writers begin anew with them.
///
/// Two participants that fell silent (one or both stopped, a network cut) drop each other when the lease
/// ends, but not at the same moment. The later one to do so forgets what it knew of the earlier one's
/// writers, and asks for it from the start. Fast DDS 2.9.1 does not answer:
///
/// - It ignores requests for what the reader once acknowledged, unless they begin with an empty one, which is
///   left out when a heartbeat comes first. An acknowledgement that goes back behind an earlier one, and a
///   request that was repeated several times without any effect, are therefore turned into that empty one.
///   One that was overtaken on its way does the same, and costs a repetition.
/// - It ignores every word whose count is not higher than the last one's. A reader of Cyclone DDS begins
///   its counts anew, and would be ignored for as long as it was heard before. They are therefore continued.
///
/// Thread-safe.
class ForgottenWriters {
 public:
  /// The patches that `word`, read from `datagram`, needs to be answered; none where it goes forward.
  void see(const Acknowledgement& word, std::span<const std::byte> datagram, std::vector<BytePatch>& patches);

 private:
  struct Reader {
    std::int64_t base = 0;
    unsigned repetitions = 0;        // of one request
    std::uint32_t count = 0;         // as last handed on
    std::uint32_t count_offset = 0;  // between the reader's count and the one that is handed on
  };
  static constexpr std::size_t kMostReaders = 16384;  // some hundred for each participant that is known

  /// Notes the word: whether its writer has to begin anew. `count`: of the word, as it is handed on.
  bool note(const Acknowledgement& word, std::uint32_t& count);

  std::mutex mutex_;
  std::map<std::array<std::byte, 20>, Reader> readers_;
};

}  // namespace tonus::bus
