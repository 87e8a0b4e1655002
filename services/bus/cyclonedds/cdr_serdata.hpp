#pragma once

#include <condition_variable>
#include <cstdint>
#include <dds/ddsi/ddsi_serdata.h>
#include <memory>
#include <mutex>

#include "services/bus/bus.hpp"

/// One payload as Cyclone DDS holds it: a `serdata` of its internal type interface (version 0.10), which
/// carries the CDR bytes as they are. Reference-counted by Cyclone; the callbacks are called from its
/// threads.
namespace tonus::bus {

/// Counts the payloads of one writer that Cyclone still holds. A volatile writer's payload goes as soon as
/// every reader has acknowledged it.
class HeldPayloads {
 public:
  void add();
  void remove();
  /// Waits until fewer than `limit` are held; false after `longest`.
  [[nodiscard]] bool wait_below(std::size_t limit, std::chrono::milliseconds longest);

 private:
  std::mutex mutex_;
  std::condition_variable removed_;
  std::size_t count_ = 0;
};

struct CdrSerdata : ddsi_serdata {
  /// `bytes` with header, padded to four; a key-only serdata has header and key.
  CdrSerdata(const ddsi_sertype* sertype, ddsi_serdata_kind data_kind, std::shared_ptr<const Payload> bytes);
  ~CdrSerdata();
  CdrSerdata(const CdrSerdata&) = delete;
  CdrSerdata& operator=(const CdrSerdata&) = delete;

  std::shared_ptr<const Payload> payload;
  Key key;
  std::uint64_t arrival =
      0;  ///< Number in the order of reception from the network, over all keys and writers.
  std::int64_t received_ns = 0;        ///< Steady clock.
  std::shared_ptr<HeldPayloads> held;  ///< Set by a writer that counts.
};

/// The callbacks; none of them throws.
[[nodiscard]] const ddsi_serdata_ops* cdr_serdata_ops();

}  // namespace tonus::bus
