#include "services/cli/study_run.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "rig_agent/plant/cohort.hpp"
#include "services/cli/operator_end.hpp"
#include "services/core/text_file.hpp"

namespace tonus::cli {
namespace {

constexpr std::chrono::seconds kRosterLimit{30};

Result<std::filesystem::path> write_profile(const std::filesystem::path& data,
                                            const plant::CohortSubject& subject) {
  std::error_code error;
  std::filesystem::create_directories(data / "profiles", error);
  if (error) {
    return fail(ErrorCode::kIo, "cannot make " + (data / "profiles").string() + ": " + error.message());
  }
  const auto file = data / "profiles" / (subject.name + ".toml");
  if (auto written = write_text_file(file, subject.profile_toml); !written) return written.error();
  return file;
}

/// Everything of one subject on services of its own.
Result<void> run_subject(SystemOptions system_options, RunOptions run, const scheduler::StudySubject& subject,
                         const std::filesystem::path& folder) {
  auto end = OperatorEnd::join(system_options.common);
  if (!end) return end.error();
  OperatorEnd& op = **end;
  auto system = System::start(system_options, op.clock());
  if (!system) return system.error();
  const auto supervise = [&] { return system->supervise("tonus demo"); };
  if (auto complete = op.wait_for_roster(kRosterLimit, supervise); !complete) return complete;
  for (const std::string& protocol : {subject.unloaded, subject.loaded, subject.instruction}) {
    if (protocol.empty()) continue;
    run.protocol = (folder / protocol).string();
    std::printf("%s, %s: ", subject.name.c_str(), protocol.c_str());
    std::fflush(stdout);
    auto ran = run_session(op.client(), run, op.clock(), supervise, [&] { return op.is_interrupted(); });
    if (!ran) return ran;
  }
  return {};
}

}  // namespace

Result<void> run_study(const SystemOptions& system, const RunOptions& run, const scheduler::Protocol& study,
                       const std::string& cohort) {
  auto subjects = plant::load_cohort(cohort);
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
    part.subject = subject.name;
    part.seed = subject.seed;
    part.profile = own.profile;
    part.is_brief = true;
    if (auto ran = run_subject(own, part, subject, std::filesystem::path(run.protocol).parent_path()); !ran)
      return fail(ran.error().code, "subject " + subject.name + ": " + ran.error().message);
  }
  return {};
}

}  // namespace tonus::cli
