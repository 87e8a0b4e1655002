// tonus reject, tonus note: what an operator says of a session that goes on.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <memory>
#include <spdlog/fmt/fmt.h>

#include "services/cli/answer.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/current_session.hpp"
#include "services/contract/review.hpp"
#include "services/contract/subject.hpp"
#include "services/core/text.hpp"

namespace tonus::cli {
namespace {

constexpr std::chrono::seconds kReplyLimit{30};
constexpr std::size_t kIdDigits = 32;

struct ReviewOptions {
  runtime::CommonOptions common;
  std::string trial;  ///< An attempt's number or a trial's id; empty: none.
  std::string text;
  std::string by;
  bool is_marker = false;
  bool is_json = false;
};

/// The trial that a person names in this session.
Result<Id> trial_named(const std::string& name, const Id& session) {
  std::uint32_t attempt = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), attempt);
  if (error == std::errc() && end == name.data() + name.size() && attempt > 0)
    return trial_id(session, attempt);
  if (name.size() >= kIdDigits) {
    if (auto id = id_from_hex(name)) return *id;
  }
  return fail(ErrorCode::kInvalidArgument,
              fmt::format("trial: '{}' is not allowed; expected an attempt's number from 1, or a trial's id",
                          shown(name.substr(0, 40))));
}

/// Checks what can be checked here, so that a mistake needs no services to be seen.
Result<void> check(const ReviewOptions& options, const char* what) {
  if (!is_utf8(options.text) || !is_utf8(options.by))
    return fail(ErrorCode::kInvalidArgument, std::string(what) + ": is not UTF-8");
  TONUS_TRY(contract::check_operator_text(what, options.text));
  TONUS_TRY(contract::check_name("--by", options.by));
  if (options.trial.empty()) return {};
  const auto named = trial_named(options.trial, kNoId);
  return named ? Result<void>() : named.error();
}

Result<void> ask(const ReviewOptions& options, v1::SessionRequest request) {
  TONUS_TRY_ASSIGN(const auto end, OperatorConnection::join(options.common));
  TONUS_TRY_ASSIGN(const auto state, current_session(*end, options.common));
  v1::SessionCommand command;
  command.session_id(state.session_id());
  command.request(request);
  command.subject_facts(contract::unknown_subject());
  command.text(options.text);
  command.requested_by(options.by);
  if (request == v1::SESSION_NOTE) command.note_kind(options.is_marker ? "marker" : "note");
  if (!options.trial.empty()) {
    TONUS_TRY_ASSIGN(const Id trial, trial_named(options.trial, state.session_id()));
    command.trial_id(trial);
  }
  TONUS_TRY_ASSIGN(const auto reply, end->client().request(std::move(command), kReplyLimit));
  print_answer(options.is_json, {{"session", to_hex(state.session_id())}, {"message", reply}}, reply + "\n");
  return {};
}

/// The command, with what every one of them has.
CLI::App* add(CLI::App& app, Command& chosen, const std::shared_ptr<ReviewOptions>& options,
              const std::string& name, const std::string& help, const char* text,
              v1::SessionRequest request) {
  auto* command = app.add_subcommand(name, help);
  runtime::add_common_options(*command, options->common);
  add_json_flag(*command, options->is_json);
  command->add_option("--by", options->by, "who says so (default: the command line)");
  command->callback([options, name, text, request, &chosen] {
    chosen = [options, name, text, request] {
      runtime::start_log("tonus " + name, options->common);
      auto outcome = check(*options, text);
      if (outcome) outcome = ask(*options, request);
      return outcome ? 0 : runtime::report("tonus " + name, outcome.error());
    };
  });
  return command;
}

}  // namespace

void add_review_commands(CLI::App& app, Command& chosen) {
  auto rejection = std::make_shared<ReviewOptions>();
  auto* reject = add(app, chosen, rejection, "reject",
                     "Rejects a trial by hand: it is left out of every estimate, and run again.", "--because",
                     v1::SESSION_REJECT_TRIAL);
  reject->add_option("trial", rejection->trial, "number of the attempt, or the trial's id")->required();
  reject->add_option("--because", rejection->text, "the reason, one line")->required();

  auto noted = std::make_shared<ReviewOptions>();
  auto* note =
      add(app, chosen, noted, "note", "Stamps a note with the rig's clock and archives it with the session.",
          "text", v1::SESSION_NOTE);
  note->add_option("text", noted->text, "one line")->required();
  note->add_option("--trial", noted->trial, "number of the attempt that it is about, or the trial's id");
  note->add_flag("--marker", noted->is_marker, "a marker, which traces show with its text");
}

}  // namespace tonus::cli
