#pragma once

#include <cstdint>
#include <fastcdr/Cdr.h>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "services/core/text.hpp"

/// Called by the generated code, where bounds.awk puts it: before it takes memory for a sequence, and where
/// it reads or writes a text. An exception ends the decoding, and services/bus/typed.cpp makes an error of
/// it.
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

/// What the reader of a message was told by repair_texts(). Fast CDR has a field for options of the
/// encapsulation, which no version of it gives a meaning.
inline constexpr std::uint16_t kRepairTexts = 1;

/// Texts of this message that are not UTF-8 are masked; else they end the decoding. For messages of an
/// archive, where refusing them would lose what they say.
inline void repair_texts(eprosima::fastcdr::Cdr& cdr) { cdr.setDDSCdrOptions(kRepairTexts); }

/// A text that was read: what may not reach a terminal or a log is masked, byte for byte.
inline void take_text(eprosima::fastcdr::Cdr& cdr, std::string& text, TextKind kind) {
  if (cdr.getDDSCdrOptions() != kRepairTexts && !is_utf8(text))
    throw std::invalid_argument("a text '" + shown(text.substr(0, 60)) + "' is not UTF-8");
  text = masked(std::move(text), kind);
}

inline void take_texts(eprosima::fastcdr::Cdr& cdr, std::vector<std::string>& texts) {
  for (std::string& text : texts) take_text(cdr, text, TextKind::kLine);
}

/// A text as it is written. One with a zero byte stays, and is refused by its length.
inline std::string written_text(const std::string& text, TextKind kind) {
  return text.find('\0') == std::string::npos ? masked(text, kind) : text;
}

inline std::vector<std::string> written_text(std::vector<std::string> texts, TextKind kind) {
  for (std::string& text : texts) text = written_text(text, kind);
  return texts;
}

}  // namespace tonus::v1
