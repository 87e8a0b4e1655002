#include "services/cli/study_run.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>

#include "services/core/text_file.hpp"
#include "services/simulation/cohort.hpp"

namespace tonus::cli {
namespace {

Result<std::filesystem::path> write_profile(const std::filesystem::path& data,
                                            const simulation::CohortSubject& subject) {
  std::error_code error;
  std::filesystem::create_directories(data / "profiles", error);
  if (error) {
    return fail(ErrorCode::kIo, "cannot make " + (data / "profiles").string() + ": " + error.message());
  }
  const auto file = data / "profiles" / (subject.name + ".toml");
  if (auto written = write_text_file(file, subject.profile_toml); !written) return written.error();
  return file;
}

/// One session after the other. File names are relative to the study's own, `run.protocol`.
Result<void> run_sessions(OperatorConnection& op, RunOptions run, const std::string& study,
                          const protocol::StudySubject& subject, const std::function<Result<void>()>& tick) {
  if (run.people.study.empty()) run.people.study = study;
  const auto folder = std::filesystem::path(run.protocol).parent_path();
  run.subject = subject.name;
  run.seed = subject.seed;
  for (const std::string& protocol : {subject.unloaded, subject.loaded, subject.instruction}) {
    if (protocol.empty()) continue;
    run.protocol = (folder / protocol).string();
    std::printf("%s, %s:%c", subject.name.c_str(), protocol.c_str(), run.is_brief ? ' ' : '\n');
    std::fflush(stdout);
    auto ran = run_session(op.client(), run, op.clock(), tick, [&] { return op.interruptions(); });
    if (!ran) return ran;
  }
  return {};
}

/// Everything of one subject on services of its own.
Result<void> run_on_own_services(const SystemOptions& system_options, const RunOptions& run,
                                 const std::string& study, const protocol::StudySubject& subject) {
  auto end = OperatorConnection::join(system_options.common);
  if (!end) return end.error();
  OperatorConnection& op = **end;
  auto system = System::start(system_options, op.clock());
  if (!system) return system.error();
  const auto supervise = [&] { return system->supervise("tonus demo"); };
  if (auto complete = op.wait_for_roster(supervise); !complete) return complete;
  return run_sessions(op, run, study, subject, supervise);
}

}  // namespace

Result<protocol::StudySubject> study_subject(const RunOptions& run, const protocol::Protocol& study) {
  std::string names;
  for (const auto& subject : study.subjects) {
    if (subject.name == run.subject) return subject;
    names += (names.empty() ? "" : ", ") + subject.name;
  }
  return fail(ErrorCode::kInvalidArgument, "--subject '" + run.subject + "' is not in the study " +
                                               run.protocol + "; expected one of " + names);
}

Result<void> run_study_subject(OperatorConnection& op, const RunOptions& run, const std::string& study,
                               const protocol::StudySubject& subject) {
  return run_sessions(op, run, study, subject, [] { return Result<void>(); });
}

Result<void> run_study(const SystemOptions& system, const RunOptions& run, const protocol::Protocol& study,
                       const std::string& cohort) {
  auto subjects = simulation::load_cohort(cohort);
  if (!subjects) return subjects.error();
  const auto data = runtime::data_folder(system.common);
  if (!data) return data.error();
  const auto profile_of = [&](const std::string& name) {
    return std::find_if(subjects->begin(), subjects->end(), [&](const auto& s) { return s.name == name; });
  };
  for (const auto& subject : study.subjects) {
    if (profile_of(subject.name) == subjects->end()) {
      return fail(ErrorCode::kInvalidArgument,
                  run.protocol + ": subject '" + subject.name + "' is not in the cohort " + cohort);
    }
  }
  for (const auto& subject : study.subjects) {
    const auto profile = write_profile(*data, *profile_of(subject.name));
    if (!profile) return profile.error();
    SystemOptions own = system;
    own.profile = profile->string();
    own.seed = std::to_string(subject.seed);
    RunOptions part = run;
    part.profile = own.profile;
    part.is_brief = true;
    if (auto ran = run_on_own_services(own, part, study.name, subject); !ran)
      return fail(ran.error().code, "subject " + subject.name + ": " + ran.error().message);
  }
  return {};
}

}  // namespace tonus::cli
