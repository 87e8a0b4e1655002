#include "services/formats/csv_table.hpp"

#include <cmath>
#include <utility>

#include "services/core/text.hpp"
#include "services/recording/number_text.hpp"

namespace tonus::formats {

void CsvLine::text(std::string_view given) {
  const std::string cell = as_cell(shown(given));
  if (cell.find_first_of(",\"\r\n") == std::string_view::npos) return plain(cell);
  separate();
  line_ += '"';
  for (const char c : cell) {
    if (c == '"') line_ += '"';
    line_ += c;
  }
  line_ += '"';
}

void CsvLine::number(double value) {
  if (!std::isfinite(value)) return nothing();
  separate();
  recording::append_number(line_, value);
}

std::string CsvLine::end() {
  is_first_ = true;
  line_ += '\n';
  return std::exchange(line_, {});
}

void CsvLine::plain(std::string_view cell) {
  separate();
  line_ += cell;
}

void CsvLine::separate() {
  if (!is_first_) line_ += ',';
  is_first_ = false;
}

}  // namespace tonus::formats
