#pragma once

#include <atomic>
#include <cstdint>
#include <dds/ddsi/ddsi_sertype.h>
#include <string>

namespace tonus::bus {

/// What Cyclone DDS takes for a type: a name, a key, XCDR1, and bytes (cdr_serdata.hpp). Owned by Cyclone
/// once it is made a topic of.
struct CdrSertype : ddsi_sertype {
  explicit CdrSertype(const std::string& name);
  CdrSertype(const CdrSertype&) = delete;
  CdrSertype& operator=(const CdrSertype&) = delete;

  /// 1, 2, ... for every sample of this type that a participant receives.
  [[nodiscard]] std::uint64_t next_arrival() const {
    return arrivals_.fetch_add(1, std::memory_order_relaxed) + 1;
  }

 private:
  mutable std::atomic<std::uint64_t> arrivals_{0};
};

}  // namespace tonus::bus
