#include "services/cli/formats_page.hpp"

#include <spdlog/fmt/fmt.h>

#include "services/formats/csv_columns.hpp"
#include "services/formats/hdf5_columns.hpp"
#include "services/store/sqlite_schema.hpp"

namespace tonus::cli {
namespace {

std::string cell(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

template <typename Row>
std::string csv_table(const char* file, std::span<const formats::CsvColumn<Row>> columns) {
  std::string text = fmt::format("\n### `{}`\n\n| column | unit | meaning |\n|---|---|---|\n", file);
  for (const auto& column : columns)
    text += fmt::format("| `{}` | {} | {} |\n", column.name, column.unit, cell(column.meaning));
  return text;
}

template <typename Row>
std::string attributes(const char* group, std::span<const formats::Attribute<Row>> all) {
  std::string names;
  for (const auto& one : all) names += fmt::format("{}`{}`", names.empty() ? "" : ", ", one.name);
  return fmt::format("\n### Attributes of `{}`\n\n{}\n", group, names);
}

Result<std::string> archive_section() {
  TONUS_TRY_ASSIGN(const auto tables, store::tables_of_schema());
  std::string text =
      "\n## The archive\n\nA SQLite file (or the same tables in the schema `tonus` of a PostgreSQL server). "
      "Ids are 16\n"
      "bytes, `*_ns` are nanoseconds of UTC, `crc32c` is the checksum of the payload beside it, payloads are "
      "CDR as the\n"
      "`.idl` files define it. Read it with `tonus show`, the exports, or SQL; never write to it.\n";
  for (const auto& table : tables) {
    std::string columns;
    for (const auto& column : table.columns)
      columns += fmt::format("{}`{}` {}", columns.empty() ? "" : ", ", column.name, column.type);
    text += fmt::format("\n### `{}`\n\n{}\n", table.name, columns);
  }
  return text;
}

std::string hdf5_section() {
  std::string text =
      "\n## HDF5\n\n`tonus export --format hdf5` writes one file. Each dataset has the attributes `units` "
      "and `description`. A trial is\n"
      "`/trials/NNNN` (its attempt), an estimate `/estimates/NNN`, a note `/notes/NNN`.\n";
  text += attributes("/", formats::session_attributes());
  text += attributes("/rig", formats::rig_attributes());
  text += attributes("/trials/NNNN", formats::trial_attributes());
  text += attributes("/estimates/NNN", formats::estimate_attributes());
  text += attributes("/notes/NNN", formats::note_attributes());
  text += "\n### Datasets of a trial, two numbers a sample\n\n| dataset | meaning |\n|---|---|\n";
  for (const auto& dataset : formats::pair_datasets())
    text += fmt::format("| `{}` | {} |\n", dataset.name, cell(dataset.description));
  return text;
}

}  // namespace

Result<std::string> formats_page() {
  TONUS_TRY_ASSIGN(const auto archive, archive_section());
  return "# Formats\n\nWhat `tonus export` writes, what an archive holds, and what `--json` prints. BIDS "
         "Motion is a standard of its own:\n"
         "[bids-specification](https://bids-specification.readthedocs.io/). Numbers without a value are "
         "empty cells (CSV), NaN\n"
         "(HDF5) or null (JSON), never 0.\n\n## CSV\n\n`columns.csv` in the exported folder has the same.\n" +
         csv_table("session.csv", formats::session_columns()) +
         csv_table("trials.csv", formats::trial_columns()) + csv_table("notes.csv", formats::note_columns()) +
         csv_table("estimates.csv", formats::estimate_columns()) +
         csv_table("samples/trial-N.csv", formats::sample_columns()) + hdf5_section() + archive +
         "\n## JSON\n\nEvery answer has `schema`, the version of its form. [JSON](json.md) lists the keys.\n";
}

}  // namespace tonus::cli
