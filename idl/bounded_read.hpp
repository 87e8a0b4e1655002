#pragma once

#include <cstdint>
#include <fastcdr/Cdr.h>
#include <stdexcept>
#include <string>

/// Called by the generated code before it takes memory for a sequence; bounds.awk puts the calls there. The
/// exception ends the decoding, and services/bus/typed.cpp makes an error of it.
namespace tonus::v1 {

inline void require_length(std::uint32_t length, std::uint32_t limit) {
  if (length <= limit) return;
  throw std::length_error("a sequence's length is " + std::to_string(length) + ", at most " +
                          std::to_string(limit) + " is allowed");
}

/// Of the sequence that is read next; leaves the reader where it was.
inline void require_length_ahead(eprosima::fastcdr::Cdr& cdr, std::uint32_t limit) {
  auto before = cdr.getState();
  std::uint32_t length = 0;
  cdr >> length;
  cdr.setState(before);
  require_length(length, limit);
}

}  // namespace tonus::v1
