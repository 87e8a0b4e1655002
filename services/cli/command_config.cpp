#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <fcntl.h>
#include <memory>
#include <sys/mman.h>

#include "services/cli/commands.hpp"
#include "services/core/file_descriptor.hpp"
#include "services/core/installation.hpp"
#include "services/core/process.hpp"
#include "services/runtime/options.hpp"

namespace tonus::cli {
namespace {

constexpr char kName[] = "tonus config";
constexpr std::array kPrograms{"tonus-rig-agent", "tonus-scheduler", "tonus-identification",
                               "tonus-archive",   "tonus-dashboard", "tonus"};

/// What it prints, standard error too, and how it ends.
struct Answer {
  std::string text;
  ProcessEnd end;
};

Result<Answer> ask(const std::vector<std::string>& words) {
  const FileDescriptor output(memfd_create("answer", MFD_CLOEXEC));
  if (!output.is_open()) return fail(ErrorCode::kIo, "memory for a program's answer is missing");
  Answer answer;
  TONUS_TRY_ASSIGN(answer.end, run_process(words, {output.get(), {}, {}}));
  std::array<char, 4096> part{};
  off_t at = 0;
  for (ssize_t n = 0; (n = pread(output.get(), part.data(), part.size(), at)) > 0; at += n)
    answer.text.append(part.data(), static_cast<std::size_t>(n));
  return answer;
}

Result<void> print(const runtime::CommonOptions& common, bool has_rig) {
  std::string refusals;
  for (const char* name : kPrograms) {
    const auto program = installation().programs / name;
    std::error_code error;
    if (!std::filesystem::exists(program, error)) continue;
    std::vector<std::string> words{program.string(), "--print-config"};
    // The command line has the common options in each of its commands: one stands for all.
    if (std::string_view(name) == "tonus") words.insert(words.begin() + 1, "status");
    if (!common.configuration_file.empty())
      words.insert(words.end(), {"--config", common.configuration_file});
    if (has_rig && std::string_view(name) == "tonus-rig-agent")
      words.insert(words.end(), {"--rig", common.rig});
    TONUS_TRY_ASSIGN(const auto answer, ask(words));
    if (answer.end.is_success()) {
      std::printf("%s\n", answer.text.c_str());
    } else if (refusals.find(answer.text) == std::string::npos) {
      refusals += answer.text;
    }
  }
  if (refusals.empty()) return {};
  if (refusals.ends_with('\n')) refusals.pop_back();
  return fail(ErrorCode::kInvalidArgument, refusals);
}

}  // namespace

void add_config_command(CLI::App& app, Command& chosen) {
  auto* command = app.add_subcommand(
      "config", "Prints the options in force of each program on this host, and where each value comes from.");
  auto common = std::make_shared<runtime::CommonOptions>();
  runtime::add_common_options(*command, *common);
  const auto* rig = command->get_option("--rig");
  command->callback([common, rig, &chosen] {
    chosen = [common, rig] {
      const auto outcome = print(*common, rig->count() > 0);
      return outcome ? 0 : runtime::report(kName, outcome.error());
    };
  });
}

}  // namespace tonus::cli
