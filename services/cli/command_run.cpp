#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <optional>

#include "services/cli/command_dry_run.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/operator_connection.hpp"
#include "services/cli/session_run.hpp"
#include "services/cli/standard_input.hpp"
#include "services/cli/study_run.hpp"
#include "services/cli/system.hpp"
#include "services/protocol/protocol_file.hpp"
#include "services/runtime/settings.hpp"
#include "services/store/open_store.hpp"

namespace tonus::cli {
namespace {

constexpr const char* kStudyProtocol = "deploy/protocols/study.toml";
constexpr const char* kStudyCohort = "deploy/profiles/cohort.toml";

void add_run_options(CLI::App& command, RunOptions& run) {
  command.add_option("protocol", run.protocol, "TOML file of the protocol; - is standard input");
  command
      .add_option("--subject", run.subject,
                  "the subject's name; for a study, the subject whose sessions to run")
      ->capture_default_str();
  command.add_option("--seed", run.seed, "of random orders and waits")->capture_default_str();
  command.add_option("--json", run.json, "file for the results; -: standard output, and nothing else there");
}

/// Standard input, where the protocol or the profile is "-", and where the results go.
struct Channels {
  StandardInput protocol;
  StandardInput profile;

  [[nodiscard]] Error told(Error error) const { return profile.told(protocol.told(std::move(error))); }
};

Result<Channels> take_channels(RunOptions& run) {
  TONUS_TRY_ASSIGN(auto protocol, StandardInput::take(run.protocol, "a protocol"));
  TONUS_TRY_ASSIGN(auto profile, StandardInput::take(run.profile, "a profile"));
  TONUS_TRY_ASSIGN(auto results, ResultsFile::create(run.json));
  run.results = std::make_shared<ResultsFile>(std::move(results));
  return Channels{std::move(protocol), std::move(profile)};
}

Result<void> check(const RunOptions& run) {
  if (run.protocol.empty() == run.dataset.empty()) {
    return fail(ErrorCode::kInvalidArgument, "protocol is missing; expected a protocol's file or --dataset");
  }
  return {};
}

/// Results of a study are in the archive: no file is taken for them.
Result<void> check_results_file(const RunOptions& run) {
  if (run.json.empty()) return {};
  return fail(ErrorCode::kInvalidArgument, "--json " + run.json + ": holds one session, and " + run.protocol +
                                               " is a study of several; they are in the archive");
}

struct StudyPart {
  std::string study;
  protocol::StudySubject subject;
};

/// Whose part of a study is to be run; none: the protocol is no study. A protocol that cannot be read is the
/// error.
Result<std::optional<StudyPart>> part_of_study(const RunOptions& run) {
  using Part = std::optional<StudyPart>;
  if (!run.dataset.empty()) {
    if (auto text = protocol_text(run); !text) return text.error();
    return Part();
  }
  const auto protocol = protocol::load_protocol(run.protocol);
  if (!protocol) return protocol.error();
  if (protocol->kind != protocol::ProtocolKind::kStudy) return Part();
  auto subject = study_subject(run, *protocol);
  if (!subject) return subject.error();
  if (auto good = check_results_file(run); !good) return good.error();
  return Part({protocol->name, std::move(*subject)});
}

Result<void> run_here(const runtime::CommonOptions& common, const RunOptions& run) {
  if (auto good = check(run); !good) return good;
  if (run.is_dry) {
    if (run.protocol.empty()) return fail(ErrorCode::kInvalidArgument, "--dry-run needs a protocol");
    return print_dry_run(run);
  }
  if (!run.like.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "--like " + run.like + ": is not allowed; expected together with --dry-run");
  }
  TONUS_TRY(check_people(run));
  TONUS_TRY_ASSIGN(const auto part, part_of_study(run));
  auto end = OperatorConnection::join(common);
  if (!end) return end.error();
  OperatorConnection& op = **end;
  if (auto complete = op.wait_for_roster(); !complete) return complete;
  if (part) return run_study_subject(op, run, part->study, part->subject);
  return run_session(
      op.client(), run, op.clock(), [] { return Result<void>(); }, [&] { return op.interruptions(); });
}

/// Watches the session that goes on, to its end.
Result<void> attach(const runtime::CommonOptions& common, const RunOptions& run) {
  if (!run.protocol.empty() || !run.dataset.empty() || run.is_dry) {
    return fail(ErrorCode::kInvalidArgument,
                "--attach watches the session that goes on: no protocol, --dataset or --dry-run is allowed");
  }
  TONUS_TRY_ASSIGN(const auto end, OperatorConnection::join(common));
  return run_session(
      end->client(), run, end->clock(), [] { return Result<void>(); }, [&] { return end->interruptions(); });
}

/// Runs a cohort, and says where its data are.
Result<void> study(SystemOptions& system_options, const RunOptions& run, const protocol::Protocol& protocol,
                   const std::string& cohort) {
  if (cohort.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                run.protocol + " is a study: --cohort must name the file of its subjects");
  }
  if (auto good = check_results_file(run); !good) return good;
  const SystemClock clock;
  const auto begun = clock.now();
  if (auto ran = run_study(system_options, run, protocol, cohort); !ran) return ran;
  const auto data = runtime::data_folder(system_options.common);
  if (!data) return data.error();
  std::printf("%zu subjects in %.1f s\n", protocol.subjects.size(),
              std::chrono::duration<double>(clock.now() - begun).count());
  const std::string store =
      system_options.store.empty() ? store::default_store(*data).string() : system_options.store;
  std::printf("archive: %s\n", store.c_str());
  return {};
}

/// A demo of a simulated or recorded arm needs no operator after a hold.
bool moves_nothing_real(const SystemOptions& options) {
  return options.driver == "simulated" || options.driver == "replay";
}

Result<void> demo(SystemOptions& system_options, RunOptions& run, const std::string& cohort) {
  run.profile = system_options.profile;
  run.dataset = system_options.dataset;
  if (auto good = check(run); !good) return good;
  if (auto text = protocol_text(run); !text) return text.error();
  if (run.dataset.empty()) {
    const auto protocol = protocol::load_protocol(run.protocol);
    if (!protocol) return protocol.error();
    if (protocol->kind == protocol::ProtocolKind::kStudy) {
      system_options.resumes_unattended |= moves_nothing_real(system_options);
      return study(system_options, run, *protocol, cohort);
    }
  } else {
    system_options.driver = "replay";
  }
  system_options.resumes_unattended |= moves_nothing_real(system_options);
  auto end = OperatorConnection::join(system_options.common);
  if (!end) return end.error();
  OperatorConnection& op = **end;
  auto system = System::start(system_options, op.clock());
  if (!system) return system.error();
  const auto supervise = [&] { return system->supervise("tonus demo"); };
  if (auto complete = op.wait_for_roster(supervise); !complete) return complete;
  if (auto ran = run_session(op.client(), run, op.clock(), supervise, [&] { return op.interruptions(); });
      !ran) {
    return ran;
  }
  const std::string store =
      system_options.store.empty() ? store::default_store(system->data()).string() : system_options.store;
  std::printf("archive: %s\n", store.c_str());
  return {};
}

}  // namespace

void add_run_command(CLI::App& app, Command& chosen) {
  auto* command =
      app.add_subcommand("run", "Runs a protocol on the services that are up, and prints the results.");
  auto common = std::make_shared<runtime::CommonOptions>();
  auto run = std::make_shared<RunOptions>();
  runtime::add_common_options(*command, *common);
  add_run_options(*command, *run);
  add_people_options(*command, run->people);
  command->add_option("--dataset", run->dataset,
                      "play every record of this BIDS dataset, instead of a protocol");
  command->add_option("--profile", run->profile,
                      "of the simulated rig, for its truth beside the results; - is standard input");
  command->add_flag("--dry-run", run->is_dry,
                    "print trials, duration and extremes for the simulated rig, and move nothing");
  command->add_option("--like", run->like,
                      "with --dry-run and a protocol with stop_when: expect as many trials as this archived "
                      "session suggests (its id or the beginning of it)");
  command->add_option("--archive", run->archive.archive, "of that session (default: the data folder's own)");
  command->add_flag("--attach", run->attaches, "watch the session that goes on, and print its results");
  command->callback([common, run, &chosen] {
    chosen = [common, run] {
      runtime::start_log("tonus run", *common);
      run->detaches = true;
      run->archive.data = common->data;
      const auto channels = take_channels(*run);
      if (!channels) return runtime::report("tonus run", channels.error());
      const auto outcome = run->attaches ? attach(*common, *run) : run_here(*common, *run);
      return outcome ? 0 : runtime::report("tonus run", channels->told(outcome.error()));
    };
  });
}

void add_demo_command(CLI::App& app, Command& chosen) {
  auto* command =
      app.add_subcommand("demo", "Starts the services, runs one protocol or dataset, and stops them.");
  auto system = std::make_shared<SystemOptions>();
  auto run = std::make_shared<RunOptions>();
  auto cohort = std::make_shared<std::string>();
  system->speed = "max";
  system->common.configuration_file = runtime::kNoFile;
  add_system_options(*command, *system);
  command->get_option("--config")->default_str(runtime::kNoFile);
  add_run_options(*command, *run);
  command->add_option("--cohort", *cohort, "TOML file of a study's simulated subjects")
      ->check(CLI::ExistingFile);
  auto is_study = std::make_shared<bool>(false);
  command->add_flag("--study", *is_study,
                    std::string("the whole study: ") + kStudyProtocol + " with " + kStudyCohort);
  command->callback([system, run, cohort, is_study, &chosen] {
    chosen = [system, run, cohort, is_study] {
      runtime::start_log("tonus demo", system->common);
      if (*is_study && run->protocol.empty()) run->protocol = kStudyProtocol;
      if (*is_study && cohort->empty()) *cohort = kStudyCohort;
      const auto channels = take_channels(*run);
      if (!channels) return runtime::report("tonus demo", channels.error());
      const auto outcome = demo(*system, *run, *cohort);
      return outcome ? 0 : runtime::report("tonus demo", channels->told(outcome.error()));
    };
  });
}

}  // namespace tonus::cli
