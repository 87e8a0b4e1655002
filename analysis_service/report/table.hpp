#pragma once

#include <string>
#include <vector>

namespace tonus::report {

/// A table of the report: text in every cell, units in the headings.
struct Table {
  std::string id;  ///< Name of its CSV file: "table1".
  std::string title;
  std::string note;  ///< A line below it; empty: none.
  std::vector<std::string> headings;
  std::vector<std::vector<std::string>> rows;
};

/// RFC 4180, a heading line first.
[[nodiscard]] std::string as_csv(const Table& table);
[[nodiscard]] std::string as_html(const Table& table);
/// For the text of an HTML element or attribute.
[[nodiscard]] std::string html_text(const std::string& text);

}  // namespace tonus::report
