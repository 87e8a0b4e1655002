#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

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

void print_rows(const char* what, const std::vector<store::RowRange>& ranges) {
  for (const auto& range : ranges) {
    std::printf("lost: %s %lld to %lld\n", what, static_cast<long long>(range.first),
                static_cast<long long>(range.last));
  }
}

void print(const store::Recovery& recovery, const std::string& target) {
  std::printf("%llu pages", static_cast<unsigned long long>(recovery.pages));
  if (!recovery.has_header) std::printf(", without a header");
  if (recovery.pages_expected > recovery.pages)
    std::printf(", %llu more are cut off",
                static_cast<unsigned long long>(recovery.pages_expected - recovery.pages));
  if (recovery.pages_from_log > 0)
    std::printf(", %llu of them newer in the write-ahead log",
                static_cast<unsigned long long>(recovery.pages_from_log));
  std::printf(
      "\ncopied to %s: %llu blocks of samples, %llu messages; %llu sessions, %llu trials\n", target.c_str(),
      static_cast<unsigned long long>(recovery.blocks), static_cast<unsigned long long>(recovery.messages),
      static_cast<unsigned long long>(recovery.sessions), static_cast<unsigned long long>(recovery.trials));
  print_rows("rows of blocks", recovery.lost_blocks);
  print_rows("rows of messages", recovery.lost_messages);
  for (const auto& what : recovery.damaged_messages) std::printf("lost: a message of %s\n", what.c_str());
  for (const auto& lost : recovery.lost_samples) {
    std::printf("lost: samples %llu to %llu of rig %s, epoch %llu\n",
                static_cast<unsigned long long>(lost.range.first),
                static_cast<unsigned long long>(lost.range.end - 1), to_hex(lost.stream.rig).c_str(),
                static_cast<unsigned long long>(lost.stream.epoch));
  }
  for (const auto& trial : recovery.incomplete_trials) std::printf("incomplete: %s\n", trial.c_str());
  if (recovery.unreadable_rows > 0)
    std::printf("%llu rows cannot be taken apart\n",
                static_cast<unsigned long long>(recovery.unreadable_rows));
  std::printf("%s\n", recovery.is_whole() ? "nothing that the file tells of is lost"
                                          : "what came after the last row that is left cannot be known");
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
      if (options->is_json)
        print_answer(true, json_of(*recovery, target), {});
      else
        print(*recovery, target);
      return 0;
    };
  });
}

}  // namespace tonus::cli
