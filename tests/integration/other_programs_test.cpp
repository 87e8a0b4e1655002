#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "services/store/archived_trial.hpp"
#include "services/store/open_store.hpp"
#include "services/store/session_reader.hpp"
#include "tests/support/made_up_session/made_up_session.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::testing {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds kLimit{120};

/// An archive with one session, and what other people's programs make of it.
class OtherPrograms : public ::testing::Test {
 protected:
  OtherPrograms() : archive_(folder_ / "archive.sqlite") {
    auto store = store::open_store_for_writing(archive_.string());
    EXPECT_TRUE(store) << store.error().message;
    auto recipe = made_up::unloaded_session();
    recipe.rejected_attempt = 6;
    record_ = made_up::put_session(**store, std::move(recipe));
    session_ = *store::read_session(**store, record_.session);
    first_ = store::read_trial_samples(**store, session_.trials[0])->samples;
  }

  int run(const fs::path& program, const std::vector<std::string>& arguments) {
    Process process(program, arguments, folder_ / "output");
    const int code = process.wait(kLimit);
    output_ = process.output();
    return code;
  }

  std::string exported(const std::string& format) {
    const auto path = (folder_ / ("exported." + format)).string();
    EXPECT_EQ(
        run(program("tonus"), {"export", "--archive", archive_.string(), "--format", format, "--out", path}),
        0)
        << output_;
    return path;
  }

  /// Runs an example of the docs, with nothing but the interpreter and its packages.
  void run_example(const fs::path& interpreter, const std::string& example,
                   const std::vector<std::string>& arguments) {
    std::vector<std::string> all{source_file("docs/examples/" + example).string()};
    all.insert(all.end(), arguments.begin(), arguments.end());
    EXPECT_EQ(run(interpreter, all), 0) << output_;
  }

  void expect_printed(const std::string& text) const {
    EXPECT_NE(output_.find(text), std::string::npos) << "'" << text << "' in:\n" << output_;
  }

  bool has_python_with(const std::string& package) {
    return fs::exists(kPython) && run(kPython, {"-c", "import " + package}) == 0;
  }

  double stiffness() const { return store::newest_estimates(session_).at(0).stiffness_N_per_m().value()[0]; }

  static constexpr const char* kPython = "/usr/bin/python3";
  TemporaryFolder folder_;
  fs::path archive_;
  store::SessionRecord record_;
  store::Session session_;
  std::vector<v1::RigSample> first_;
  std::string output_;
};

TEST_F(OtherPrograms, BidsValidatorFindsNoErrorInAnExportedSession) {
  const auto validator = source_file("tests/bids/node_modules/.bin/bids-validator");
  if (!fs::exists("/usr/bin/node") || !fs::exists(validator)) {
    GTEST_SKIP() << "bids-validator is not installed: npm install --prefix tests/bids --ignore-scripts "
                    "--no-package-lock";
  }
  const auto dataset = exported("bids");
  EXPECT_EQ(run("/usr/bin/node", {"--no-warnings", validator.string(), "--json", dataset}), 0) << output_;
  const auto report = nlohmann::json::parse(output_.substr(output_.find('{')), nullptr, false);
  ASSERT_TRUE(report.is_object()) << output_;
  EXPECT_TRUE(report.at("issues").at("errors").empty()) << report.at("issues").at("errors").dump(1);
  const auto& types = report.at("summary").at("dataTypes");
  EXPECT_NE(std::find(types.begin(), types.end(), "motion"), types.end()) << types;
}

TEST_F(OtherPrograms, PythonReadsTheArchiveItself) {
  if (!has_python_with("numpy")) GTEST_SKIP() << "python3-numpy is not installed";
  run_example(kPython, "read_archive.py", {archive_.string()});
  expect_printed("session " + to_hex(record_.session) + ", subject sub-07, trial 1: 650 samples");
  expect_printed(fmt::format("first encoder count {:.6f}", first_.front().encoder_count()[0]));
  expect_printed(fmt::format("last force {:.9f} V", first_.back().force_V()[1]));
}

TEST_F(OtherPrograms, PythonReadsAnExportedDataset) {
  if (!has_python_with("numpy")) GTEST_SKIP() << "python3-numpy is not installed";
  run_example(kPython, "read_bids.py", {exported("bids")});
  expect_printed("acq-reference_run-01: 10400 rows, 15 of 16 perturbations count");
}

TEST_F(OtherPrograms, H5pyReadsAnExportedSessionWithItsUnits) {
  if (!has_python_with("h5py")) GTEST_SKIP() << "python3-h5py is not installed";
  run_example(kPython, "read_hdf5.py", {exported("hdf5")});
  expect_printed("subject sub-07");
  expect_printed("trial 1: 650 samples, force in N");
  expect_printed(fmt::format("reference: K(1,1) = {} N/m", stiffness()));
}

TEST_F(OtherPrograms, RReadsTheTablesAndTheArchive) {
  if (!fs::exists("/usr/bin/Rscript")) GTEST_SKIP() << "r-base-core is not installed";
  run_example("/usr/bin/Rscript", "read_session.R", {exported("csv"), archive_.string()});
  expect_printed("16 trials, 15 count; trial 1 has 650 samples");
  expect_printed(fmt::format("reference: K(1,1) = {:.10g} N/m", stiffness()));
}

}  // namespace
}  // namespace tonus::testing
