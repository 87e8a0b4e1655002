#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "services/cli/answer.hpp"
#include "services/cli/archive_option.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/progress_bar.hpp"
#include "services/core/json_text.hpp"
#include "services/runtime/options.hpp"
#include "services/store/session_reader.hpp"
#include "services/verification/verification.hpp"

namespace tonus::cli {
namespace {

using verification::Verification;

struct VerifyOptions {
  ArchiveOption archive;
  std::string session;
  bool is_json = false;
};

void print(const store::SessionRecord& record, const Verification& v) {
  std::printf("session %s%s\n", to_hex(record.session).c_str(), v.is_over ? "" : " (goes on)");
  std::printf("checksums: %llu blocks, %llu damaged; %llu messages, %llu damaged\n",
              static_cast<unsigned long long>(v.blocks), static_cast<unsigned long long>(v.damaged_blocks),
              static_cast<unsigned long long>(v.messages),
              static_cast<unsigned long long>(v.damaged_messages));
  std::size_t certified = 0;
  for (const auto& trial : v.trials) certified += trial.is_certified ? 1 : 0;
  const auto& c = v.certificate;
  std::printf(
      "samples: %llu expected, %llu received, %llu resent, %llu duplicated, %llu missing; %zu of %zu "
      "trials certified\n",
      static_cast<unsigned long long>(c.expected), static_cast<unsigned long long>(c.received),
      static_cast<unsigned long long>(c.resent), static_cast<unsigned long long>(c.duplicated),
      static_cast<unsigned long long>(c.missing), certified, v.trials.size());
  for (const auto& trial : v.trials) {
    if (trial.absent == 0 && trial.certificate.resent == 0 && trial.certificate.duplicated == 0) continue;
    std::printf("  trial %u: %llu found, %llu missing, %llu resent, %llu duplicated\n", trial.attempt,
                static_cast<unsigned long long>(trial.found), static_cast<unsigned long long>(trial.absent),
                static_cast<unsigned long long>(trial.certificate.resent),
                static_cast<unsigned long long>(trial.certificate.duplicated));
  }
  std::size_t equal = 0;
  for (const auto& verdict : v.verdicts) equal += verdict.is_equal ? 1 : 0;
  if (!v.settings.empty()) std::printf("identified again with %s\n", v.settings.c_str());
  std::printf("verdicts: %zu of %zu equal\n", equal, v.verdicts.size());
  if (!v.estimates.empty())
    std::printf("%-28s %-16s %-18s %6s  %-15s %s\n", "condition", "method", "model", "trials", "published",
                "remark");
  for (const auto& check : v.estimates) {
    const auto& e = check.estimate;
    std::printf("%-28s %-16s %-18s %6u  %-15s %s\n", verification::condition_text(e).c_str(),
                e.method().c_str(), e.model().c_str(), e.trials_used(), verification::name_of(check.outcome),
                check.remark.c_str());
  }
  for (const auto& remark : v.remarks) std::printf("remark: %s\n", remark.c_str());
  for (const auto& problem : v.problems) std::printf("problem: %s\n", problem.c_str());
  std::printf("%s\n", v.is_well() ? "all is well" : fmt::format("{} problems", v.problems.size()).c_str());
}

nlohmann::json as_json(const store::SessionRecord& record, const Verification& v) {
  using nlohmann::json;
  json root{{"schema", 1},
            {"session", to_hex(record.session)},
            {"is_well", v.is_well()},
            {"is_over", v.is_over},
            {"blocks", v.blocks},
            {"damaged_blocks", v.damaged_blocks},
            {"messages", v.messages},
            {"damaged_messages", v.damaged_messages},
            {"settings", v.settings},
            {"problems", v.problems},
            {"remarks", v.remarks},
            {"trials", json::array()},
            {"verdicts", json::array()},
            {"conditions", json::array()}};
  for (const auto& trial : v.trials) {
    root["trials"].push_back({{"attempt", trial.attempt},
                              {"is_certified", trial.is_certified},
                              {"expected", trial.certificate.expected},
                              {"received", trial.certificate.received},
                              {"resent", trial.certificate.resent},
                              {"duplicated", trial.certificate.duplicated},
                              {"missing", trial.certificate.missing},
                              {"found", trial.found}});
  }
  for (const auto& verdict : v.verdicts) {
    root["verdicts"].push_back({{"attempt", verdict.attempt},
                                {"is_equal", verdict.is_equal},
                                {"published", verdict.published},
                                {"found", verdict.found}});
  }
  for (const auto& check : v.estimates) {
    root["conditions"].push_back({{"condition", verification::condition_text(check.estimate)},
                                  {"method", check.estimate.method()},
                                  {"model", check.estimate.model()},
                                  {"trials_used", check.estimate.trials_used()},
                                  {"outcome", verification::name_of(check.outcome)},
                                  {"largest_difference", check.difference.largest},
                                  {"where", check.difference.where},
                                  {"remark", check.remark}});
  }
  return root;
}

Result<bool> verify(const VerifyOptions& options) {
  auto store = open_to_read(options.archive);
  if (!store) return store.error();
  const auto record = store::find_session(**store, options.session);
  if (!record) return record.error();
  ProgressBar bar("trials");
  const auto verification = verification::verify_session(
      **store, *record, [&bar](std::uint64_t done, std::uint64_t total) { bar.show(done, total, ""); });
  bar.clear();
  if (!verification) return verification.error();
  if (options.is_json) {
    std::printf("%s\n", json_text(as_json(*record, *verification)).c_str());
  } else {
    print(*record, *verification);
  }
  return verification->is_well();
}

}  // namespace

void add_verify_command(CLI::App& app, Command& chosen) {
  auto* command = app.add_subcommand(
      "verify", "Checks an archived session: checksums, completeness, and results anew from the raw data.");
  auto options = std::make_shared<VerifyOptions>();
  command->add_option("session", options->session, "its id or the beginning of it (default: the last one)");
  add_archive_option(*command, options->archive);
  add_json_flag(*command, options->is_json);
  command->callback([options, &chosen] {
    chosen = [options] {
      const auto is_well = verify(*options);
      if (!is_well) return runtime::report("tonus verify", is_well.error());
      return *is_well ? 0 : 1;
    };
  });
}

}  // namespace tonus::cli
