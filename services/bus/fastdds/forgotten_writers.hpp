#pragma once

#include <map>
#include <mutex>

#include "services/bus/fastdds/rtps_check.hpp"

namespace tonus::bus {

/// Finds remote readers of discovery that have forgotten this participant, and has their writer begin anew.
///
/// Two participants that fell silent (both stopped, a network cut) drop each other when the lease ends, but
/// not at the same moment. The later one to do so forgets what it knew of the earlier one's writers and
/// readers, and asks for it from the start; Fast DDS 2.9.1 answers only a reader whose first word is an empty
/// request, which is left out when a heartbeat comes first. It ignores requests for what the reader once
/// acknowledged, so the two never hear each other again. An acknowledgement that goes back behind an earlier
/// one is therefore turned into that empty request. One that was overtaken on its way does the same, and
/// costs a repetition. Thread-safe.
class ForgottenWriters {
 public:
  /// The patches that turn `word`, read from `datagram`, into a first word; none where it goes forward.
  void see(const Acknowledgement& word, std::span<const std::byte> datagram, std::vector<BytePatch>& patches);

 private:
  static constexpr std::size_t kMostReaders = 1024;  // two for each participant that is known

  std::mutex mutex_;
  std::map<std::array<std::byte, 20>, std::int64_t> bases_;
};

}  // namespace tonus::bus
