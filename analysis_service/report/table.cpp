#include "analysis_service/report/table.hpp"

#include "services/core/text.hpp"

namespace tonus::report {
namespace {

/// Numbers with their signs, spreads and separators: no text that a spreadsheet could take for a formula.
bool is_of_numbers(const std::string& cell) {
  return cell.find_first_not_of("0123456789.,+-e %\xC2\xB1") == std::string::npos;
}

std::string csv_cell(const std::string& given) {
  std::string text = is_of_numbers(given) ? given : as_cell(shown(given));
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string csv_line(const std::vector<std::string>& cells) {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) line += (i == 0 ? "" : ",") + csv_cell(cells[i]);
  return line + "\r\n";
}

std::string html_row(const std::vector<std::string>& cells, const char* element) {
  std::string row = "<tr>";
  for (const std::string& cell : cells)
    row += std::string("<") + element + ">" + html_text(cell) + "</" + element + ">";
  return row + "</tr>\n";
}

}  // namespace

std::string html_text(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

std::string as_csv(const Table& table) {
  std::string text = csv_line(table.headings);
  for (const auto& row : table.rows) text += csv_line(row);
  return text;
}

std::string as_html(const Table& table) {
  std::string text = "<section id=\"" + table.id + "\">\n<h3>" + html_text(table.title) +
                     "</h3>\n<div class=\"wide\"><table>\n<thead>" + html_row(table.headings, "th") +
                     "</thead>\n<tbody>\n";
  for (const auto& row : table.rows) text += html_row(row, "td");
  text += "</tbody></table></div>\n";
  if (!table.note.empty()) text += "<p class=\"note\">" + html_text(table.note) + "</p>\n";
  return text + "<p><a href=\"" + table.id + ".csv\">" + table.id + ".csv</a></p>\n</section>\n";
}

}  // namespace tonus::report
