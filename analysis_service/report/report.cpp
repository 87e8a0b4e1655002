#include "analysis_service/report/report.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <spdlog/fmt/fmt.h>

#include "analysis_service/report/figures.hpp"
#include "analysis_service/report/tables.hpp"
#include "services/core/file_descriptor.hpp"
#include "services/core/process.hpp"
#include "services/core/text_file.hpp"
#include "services/runtime/version.hpp"

namespace tonus::report {
namespace {

constexpr const char* kStyle =
    "body{font:16px/1.5 system-ui,sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem;color:#111;"
    "background:#fff}table{border-collapse:collapse;font-size:.85rem}th,td{border:1px solid "
    "#999;padding:.2rem "
    ".5rem;text-align:left;white-space:nowrap}th{background:#eee}.wide{overflow-x:auto}.note{font-size:.9rem;"
    "color:#444}figure{margin:2rem 0}img{max-width:100%;background:#fff}";

std::string script_of(const Figure& figure, const char* terminal, const char* extension) {
  return fmt::format(
      "set encoding utf8\nset terminal {} size {}\nset output '{}.{}'\n{}", terminal,
      std::string(extension) == "svg"
          ? fmt::format("{:.0f},{:.0f} font 'Helvetica,13'", 50.0 * figure.width_cm, 50.0 * figure.height_cm)
          : fmt::format("{:.1f}cm,{:.1f}cm font 'Helvetica,10'", figure.width_cm, figure.height_cm),
      figure.id, extension, figure.script);
}

/// Runs gnuplot in the folder.
Result<void> run_gnuplot(const std::filesystem::path& folder, const std::string& script_file) {
  if (!find_program("gnuplot"))
    return fail(ErrorCode::kUnavailable, "gnuplot is not installed; figures need it (package gnuplot-nox)");
  const auto log = folder / (script_file + ".log");
  const FileDescriptor output(open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
  if (!output.is_open())
    return fail(ErrorCode::kIo, fmt::format("{}: {}", log.string(), std::strerror(errno)));
  const auto end = run_process({"gnuplot", script_file},
                               {.output = output.get(), .folder = folder, .environment = {"LC_ALL=C.UTF-8"}});
  const auto said = read_text_file(log);
  std::error_code none;
  std::filesystem::remove(log, none);
  if (!end) return end.error();
  if (end->is_success()) return {};
  return fail(ErrorCode::kUnavailable,
              fmt::format("gnuplot {} {}: {}", script_file, end->text(), said ? *said : std::string()));
}

/// Replaces the creation date of a PDF of gnuplot by zeros, in place: the same study gives the same bytes.
Result<void> clear_creation_date(const std::filesystem::path& file) {
  auto pdf = read_text_file(file);
  if (!pdf) return pdf.error();
  constexpr std::string_view kKey = "/CreationDate (D:";
  const auto key = pdf->find(kKey);
  if (key == std::string::npos) return {};
  for (auto at = key + kKey.size(); at < pdf->size() && (*pdf)[at] != ')'; ++at) {
    char& c = (*pdf)[at];
    if (c >= '0' && c <= '9') c = '0';
  }
  return write_text_file(file, *pdf);
}

Result<void> draw(const Figure& figure, const std::filesystem::path& folder) {
  for (const DataFile& file : figure.data) {
    if (auto written = write_text_file(folder / file.name, file.text); !written) return written;
  }
  const std::string script = script_of(figure, "svg enhanced background '#ffffff'", "svg") +
                             "unset output\nreset\n" + script_of(figure, "pdfcairo enhanced", "pdf") +
                             "unset output\n";
  const std::string script_file = figure.id + ".gp";
  if (auto written = write_text_file(folder / script_file, script); !written) return written;
  if (auto drawn = run_gnuplot(folder, script_file); !drawn) return drawn;
  return clear_creation_date(folder / (figure.id + ".pdf"));
}

std::string html_of(const Figure& figure) {
  std::string text = fmt::format(
      "<figure id=\"{0}\">\n<img src=\"{0}.svg\" alt=\"{1}\">\n<figcaption><strong>{1}</strong> {2} <a "
      "href=\"{0}.pdf\">PDF</a>, <a href=\"{0}.gp\">script</a>",
      figure.id, html_text(figure.title), html_text(figure.caption));
  for (const DataFile& file : figure.data) text += fmt::format(", <a href=\"{0}\">{0}</a>", file.name);
  return text + "</figcaption>\n</figure>\n";
}

Table sources_table(const study::Study& study) {
  Table table{
      "sessions",
      "What this report is made from",
      "Settings: window 1.0 s from onset; low-pass 10 Hz; state-variable filter with damping ratio 0.1 and "
      "the natural frequency that each condition's data ask for; 95 % intervals by leaving out one trial "
      "at a time.",
      {"subject", "protocol", "session", "seed", "trials", "rejected", "measured by"},
      {}};
  for (const study::Subject& subject : study.subjects) {
    for (const auto& session : {subject.unloaded, subject.loaded}) {
      if (!session) continue;
      table.rows.push_back({subject.name, session->protocol, to_hex(session->session),
                            std::to_string(session->seed), std::to_string(session->trials),
                            std::to_string(session->rejected), "tonus " + session->software_version});
    }
  }
  return table;
}

}  // namespace

Result<void> write_report(const study::Study& study, const std::filesystem::path& folder,
                          const std::function<void(const std::string&)>& progress) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(ErrorCode::kIo, fmt::format("cannot make {}: {}", folder.string(), error.message()));

  progress("tables");
  const std::vector<Table> paper{table_one(study), table_two(study), table_three(study), table_four(study)};
  progress("what the numbers are worth");
  const std::vector<Table> beyond{coverage_table(study), intervals_table(study), worth_table(study),
                                  spread_table(study),   patterns_table(study),  loaded_table(study)};
  const Table sources = sources_table(study);
  const std::vector<Figure> drawn = figures(study);
  for (const auto* tables : {&paper, &beyond}) {
    for (const Table& table : *tables) {
      if (auto written = write_text_file(folder / (table.id + ".csv"), as_csv(table)); !written)
        return written;
    }
  }
  if (auto written = write_text_file(folder / (sources.id + ".csv"), as_csv(sources)); !written)
    return written;
  for (const Figure& figure : drawn) {
    progress(figure.id);
    if (auto good = draw(figure, folder); !good) return good;
  }

  std::string page = fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width\">\n<title>Postural arm "
      "impedance</title>\n<style>{}</style>\n</head>\n<body>\n"
      "<h1>Postural arm impedance: {} subjects</h1>\n<p>Tables and figures bear the numbers of Dolan, "
      "Friedman "
      "&amp; Nagurka, <cite>Dynamic and loaded impedance components in the maintenance of human arm "
      "posture</cite> "
      "(1993). Made by tonus {} from the archive {}.{}</p>\n",
      kStyle, study.subjects.size(), runtime::kVersion, html_text(study.archive),
      study.is_simulated ? " The subjects are simulated: <em>true</em> values are those of the simulation."
                         : "");
  page += "<nav><ul>\n";
  const auto link = [&page](const std::string& id, const std::string& title) {
    page += fmt::format("<li><a href=\"#{}\">{}</a></li>\n", id, html_text(title));
  };
  for (const Table& table : paper) link(table.id, table.title);
  for (const Figure& figure : drawn) link(figure.id, figure.title);
  for (const Table& table : beyond) link(table.id, table.title);
  link(sources.id, sources.title);
  page += "</ul></nav>\n";
  for (const Table& table : paper) page += as_html(table);
  for (const Figure& figure : drawn) page += html_of(figure);
  page += "<h2>Beyond the paper</h2>\n";
  for (const Table& table : beyond) page += as_html(table);
  page += as_html(sources) + "</body>\n</html>\n";
  return write_text_file(folder / "index.html", page);
}

}  // namespace tonus::report
