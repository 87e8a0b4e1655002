#include <CLI/CLI.hpp>
#include <memory>
#include <spdlog/fmt/fmt.h>

#include "services/cli/answer.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/progress_bar.hpp"
#include "services/runtime/options.hpp"
#include "services/store/recovery.hpp"

namespace tonus::cli {
namespace {

struct RecoverOptions {
  std::string file;
  std::string out;
  bool is_json = false;
};

std::string text_of(const char* what, const std::vector<store::RowRange>& ranges) {
  std::string text;
  for (const auto& range : ranges) text += fmt::format("lost: {} {} to {}\n", what, range.first, range.last);
  return text;
}

std::string text_of(const store::Recovery& recovery, const std::string& target) {
  std::string text = fmt::format("{} pages", recovery.pages);
  if (!recovery.has_header) text += ", without a header";
  if (recovery.pages_expected > recovery.pages)
    text += fmt::format(", {} more are cut off", recovery.pages_expected - recovery.pages);
  if (recovery.pages_from_log > 0)
    text += fmt::format(", {} of them newer in the write-ahead log", recovery.pages_from_log);
  text += fmt::format("\ncopied to {}: {} blocks of samples, {} messages; {} sessions, {} trials\n", target,
                      recovery.blocks, recovery.messages, recovery.sessions, recovery.trials);
  text +=
      text_of("rows of blocks", recovery.lost_blocks) + text_of("rows of messages", recovery.lost_messages);
  for (const auto& what : recovery.damaged_messages) text += fmt::format("lost: a message of {}\n", what);
  for (const auto& lost : recovery.lost_samples) {
    text += fmt::format("lost: samples {} to {} of rig {}, epoch {}\n", lost.range.first, lost.range.end - 1,
                        to_hex(lost.stream.rig), lost.stream.epoch);
  }
  for (const auto& trial : recovery.incomplete_trials) text += fmt::format("incomplete: {}\n", trial);
  if (recovery.unreadable_rows > 0)
    text += fmt::format("{} rows cannot be taken apart\n", recovery.unreadable_rows);
  return text + (recovery.is_whole() ? "nothing that the file tells of is lost\n"
                                     : "what came after the last row that is left cannot be known\n");
}

nlohmann::json json_of(const std::vector<store::RowRange>& ranges) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& range : ranges) list.push_back({range.first, range.last});
  return list;
}

nlohmann::json json_of(const store::Recovery& recovery, const std::string& target) {
  nlohmann::json samples = nlohmann::json::array();
  for (const auto& lost : recovery.lost_samples)
    samples.push_back({{"rig", to_hex(lost.stream.rig)},
                       {"epoch", lost.stream.epoch},
                       {"first", lost.range.first},
                       {"last", lost.range.end - 1}});
  return {{"to", target},
          {"pages", recovery.pages},
          {"pages_expected", recovery.pages_expected},
          {"pages_from_log", recovery.pages_from_log},
          {"has_header", recovery.has_header},
          {"blocks", recovery.blocks},
          {"messages", recovery.messages},
          {"sessions", recovery.sessions},
          {"trials", recovery.trials},
          {"lost_blocks", json_of(recovery.lost_blocks)},
          {"lost_messages", json_of(recovery.lost_messages)},
          {"damaged_messages", recovery.damaged_messages},
          {"lost_samples", samples},
          {"incomplete_trials", recovery.incomplete_trials},
          {"unreadable_rows", recovery.unreadable_rows},
          {"is_whole", recovery.is_whole()}};
}

}  // namespace

void add_recover_command(CLI::App& app, Command& chosen) {
  auto* command = app.add_subcommand(
      "recover", "Copies what can be read of a damaged archive file to a new one, and lists what was lost.");
  auto options = std::make_shared<RecoverOptions>();
  command->add_option("file", options->file, "the damaged SQLite file; it is not changed")->required();
  command->add_option("--out", options->out, "the new archive (default: FILE.recovered.sqlite)");
  add_json_flag(*command, options->is_json);
  command->callback([options, &chosen] {
    chosen = [options] {
      const std::string target = options->out.empty() ? options->file + ".recovered.sqlite" : options->out;
      ProgressBar bar("pages and rows");
      const auto recovery = store::recover_archive(
          options->file, target,
          [&bar](std::uint64_t done, std::uint64_t total) { bar.show(done, total, ""); });
      bar.clear();
      if (!recovery) return runtime::report("tonus recover", recovery.error());
      print_answer(options->is_json, json_of(*recovery, target), text_of(*recovery, target));
      return 0;
    };
  });
}

}  // namespace tonus::cli
