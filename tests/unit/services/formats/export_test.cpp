#include <csignal>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <set>
#include <sstream>
#include <sys/resource.h>

#include "services/core/text_file.hpp"
#include "services/formats/csv_export.hpp"
#include "services/formats/hdf5_export.hpp"
#include "services/formats/xdf_export.hpp"
#include "services/store/archived_trial.hpp"
#include "services/store/memory_store.hpp"
#include "tests/support/made_up_session/made_up_session.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::formats {
namespace {

std::vector<std::string> lines_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::stringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  return cells;
}

class Export : public ::testing::Test {
 protected:
  Export() {
    auto recipe = made_up::unloaded_session();
    recipe.rejected_attempt = 2;
    recipe.is_block_lost = [](std::uint64_t first) { return first == 1750; };
    const auto record = made_up::put_session(store_, std::move(recipe));
    session_ = *store::read_session(store_, record.session);
  }

  store::MemoryStore store_;
  store::Session session_;
  ::tonus::testing::TemporaryFolder folder_;
};

TEST_F(Export, WritesOneRowASampleAsCsvWithNumbersThatReadBackTheSame) {
  const auto done = export_csv(store_, session_, folder_ / "csv");
  ASSERT_TRUE(done) << done.error().message;
  const auto lines = lines_of(folder_ / "csv" / "samples" / "trial-1.csv");
  ASSERT_EQ(lines.size(), 651U);
  const auto header = cells_of(lines[0]);
  const auto samples = store::read_trial_samples(store_, session_.trials[0]);
  ASSERT_TRUE(samples);
  for (std::size_t row : {0U, 300U, 649U}) {
    const auto cells = cells_of(lines[row + 1]);
    ASSERT_EQ(cells.size(), header.size());
    const auto column = [&](const std::string& name) {
      return cells.at(
          static_cast<std::size_t>(std::find(header.begin(), header.end(), name) - header.begin()));
    };
    EXPECT_EQ(std::stod(column("q1_count")), samples->samples[row].encoder_count()[0]);
    EXPECT_EQ(std::stod(column("f2_V")), samples->samples[row].force_V()[1]);
    EXPECT_EQ(std::stoull(column("sequence")), 1000U + row);
  }
}

TEST_F(Export, LeavesCellsEmptyWhereNothingIsThere) {
  ASSERT_TRUE(export_csv(store_, session_, folder_ / "csv"));
  const auto lines = lines_of(folder_ / "csv" / "samples" / "trial-2.csv");
  ASSERT_EQ(lines.size(), 651U);
  EXPECT_EQ(lines[101].substr(0, 5), "1750,");
  EXPECT_EQ(lines[101].substr(lines[101].size() - 13), ",,,,,,,,,,,,,");
}

TEST_F(Export, DescribesEveryColumnOfEveryCsvFile) {
  ASSERT_TRUE(export_csv(store_, session_, folder_ / "csv"));
  std::set<std::string> described;
  for (const auto& line : lines_of(folder_ / "csv" / "columns.csv")) {
    const auto cells = cells_of(line);
    described.insert(cells[0] + ":" + cells[1]);
  }
  for (const auto& [file, name] : {std::pair{"trials.csv", "trials.csv"},
                                   {"session.csv", "session.csv"},
                                   {"notes.csv", "notes.csv"},
                                   {"estimates.csv", "estimates.csv"},
                                   {"samples/trial-1.csv", "samples/trial-N.csv"}}) {
    for (const auto& column : cells_of(lines_of(folder_ / "csv" / file)[0]))
      EXPECT_TRUE(described.contains(std::string(name) + ":" + column)) << file << " " << column;
  }
}

TEST_F(Export, SaysInTheTrialsTableWhyOneDoesNotCount) {
  ASSERT_TRUE(export_csv(store_, session_, folder_ / "csv"));
  const auto lines = lines_of(folder_ / "csv" / "trials.csv");
  ASSERT_EQ(lines.size(), 17U);
  EXPECT_NE(lines[1].find(",true,"), std::string::npos);
  EXPECT_NE(lines[2].find(",false,"), std::string::npos);
  EXPECT_NE(lines[2].find("broken off"), std::string::npos);
}

TEST_F(Export, SaysWhoWasMeasuredWhatWasNotedAndWhoRejectedATrial) {
  store::MemoryStore store;
  auto recipe = made_up::unloaded_session();
  recipe.reviewed_attempt = 3;
  recipe.set_plan = [](v1::SessionPlan& plan) {
    plan.subject_facts().age_years(31.0);
    plan.subject_facts().sex("female");
    plan.operator_name("Ada");
    plan.study("=posture");  // no formula in a spreadsheet
    plan.is_pilot(true);
  };
  v1::SessionNote note;
  note.kind("marker");
  note.text("music");
  note.written_by("Ada");
  note.trial_id(recipe.trials.at(0).report.plan.trial);
  recipe.notes = {note};
  const auto record = made_up::put_session(store, std::move(recipe));
  const auto session = *store::read_session(store, record.session);
  ASSERT_TRUE(export_csv(store, session, folder_ / "csv"));
  const auto trials = lines_of(folder_ / "csv" / "trials.csv");
  EXPECT_NE(trials[3].find(",false,rejected by hand by Ada: coughed,"), std::string::npos) << trials[3];
  EXPECT_NE(trials[4].find(",true,"), std::string::npos);
  const auto facts = lines_of(folder_ / "csv" / "session.csv");
  ASSERT_EQ(facts.size(), 2U);
  EXPECT_NE(facts[1].find(",Ada,'=posture,true,31,female,,"), std::string::npos) << facts[1];
  const auto notes = lines_of(folder_ / "csv" / "notes.csv");
  ASSERT_EQ(notes.size(), 2U);
  EXPECT_NE(notes[1].find(",marker,1,music,Ada,,"), std::string::npos) << notes[1];  // no rig was heard

  ASSERT_TRUE(export_hdf5(store, session, folder_ / "session.h5"));
  const hid_t file = H5Fopen((folder_ / "session.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  for (const char* name : {"operator", "study", "is_pilot", "age_years", "height_m"})
    EXPECT_GT(H5Aexists(file, name), 0) << name;
  for (const char* name : {"kind", "text", "attempt", "has_rig_clock"})
    EXPECT_GT(H5Aexists_by_name(file, "/notes/001", name, H5P_DEFAULT), 0) << name;
  H5Fclose(file);
}

TEST_F(Export, WritesHdf5WithAUnitAtEveryDataset) {
  const auto path = folder_ / "session.h5";
  const auto done = export_hdf5(store_, session_, path);
  ASSERT_TRUE(done) << done.error().message;
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  std::size_t datasets = 0;
  std::size_t without_unit = 0;
  std::pair<std::size_t*, std::size_t*> counts{&datasets, &without_unit};
  H5Ovisit2(
      file, H5_INDEX_NAME, H5_ITER_NATIVE,
      [](hid_t root, const char* name, const H5O_info_t* info, void* data) -> herr_t {
        auto& [all, bad] = *static_cast<std::pair<std::size_t*, std::size_t*>*>(data);
        if (info->type != H5O_TYPE_DATASET) return 0;
        ++*all;
        if (H5Aexists_by_name(root, name, "units", H5P_DEFAULT) <= 0) ++*bad;
        return 0;
      },
      &counts, H5O_INFO_BASIC);
  EXPECT_GT(datasets, 16U * 9U);
  EXPECT_EQ(without_unit, 0U);
  const hid_t encoder = H5Dopen2(file, "/trials/0001/encoder", H5P_DEFAULT);
  ASSERT_GE(encoder, 0);
  std::vector<double> values(1300);
  ASSERT_GE(H5Dread(encoder, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);
  const auto samples = store::read_trial_samples(store_, session_.trials[0]);
  ASSERT_TRUE(samples);
  EXPECT_EQ(values[600], samples->samples[300].encoder_count()[0]);
  EXPECT_EQ(values[601], samples->samples[300].encoder_count()[1]);
  H5Dclose(encoder);
  H5Fclose(file);
}

/// Files of this process may have so many bytes, as on a disk that fills up; nothing else writes meanwhile.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() { ::setrlimit(RLIMIT_FSIZE, &before_); }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
};

TEST_F(Export, OfCsvThatFailsLeavesNothingAndTheNextOneWorks) {
  for (const rlim_t bytes : {0U, 100U, 50000U}) {
    Result<void> failed;
    {
      const FileSizeLimit limit(bytes);
      failed = export_csv(store_, session_, folder_ / "csv");
    }
    ASSERT_FALSE(failed) << bytes;
    EXPECT_NE(failed.error().message.find("File too large"), std::string::npos) << failed.error().message;
    EXPECT_TRUE(std::filesystem::is_empty(folder_.path())) << bytes;
  }
  EXPECT_TRUE(export_csv(store_, session_, folder_ / "csv"));
}

TEST_F(Export, OfHdf5ThatFailsNamesTheReasonLeavesNothingAndTheNextOneWorks) {
  for (const rlim_t bytes : {0U, 3000U, 100'000U, 800'000U}) {
    Result<void> failed;
    {
      const FileSizeLimit limit(bytes);
      failed = export_hdf5(store_, session_, folder_ / "session.h5");
    }
    ASSERT_FALSE(failed) << bytes;
    EXPECT_NE(failed.error().message.find("File too large"), std::string::npos) << failed.error().message;
    EXPECT_TRUE(std::filesystem::is_empty(folder_.path())) << bytes;
  }
  EXPECT_TRUE(export_hdf5(store_, session_, folder_ / "session.h5"));
}

TEST_F(Export, OfHdf5ThatFailsLetsTheProgramEnd) {
  const auto fail_and_end = [&] {
    const FileSizeLimit limit(100'000);
    const bool has_failed = !export_hdf5(store_, session_, folder_ / "session.h5");
    std::exit(has_failed ? 7 : 1);
  };
  EXPECT_EXIT(fail_and_end(), ::testing::ExitedWithCode(7), "");
}

TEST_F(Export, OfXdfThatFailsNamesTheReasonLeavesNothingAndTheNextOneWorks) {
  for (const rlim_t bytes : {0U, 100U, 3000U, 800'000U}) {
    Result<void> failed;
    {
      const FileSizeLimit limit(bytes);
      failed = export_xdf(store_, session_, folder_ / "session.xdf");
    }
    ASSERT_FALSE(failed) << bytes;
    EXPECT_NE(failed.error().message.find("File too large"), std::string::npos) << failed.error().message;
    EXPECT_TRUE(std::filesystem::is_empty(folder_.path())) << bytes;
  }
  EXPECT_TRUE(export_xdf(store_, session_, folder_ / "session.xdf"));
}

TEST_F(Export, OverwritesNothing) {
  std::ofstream(folder_ / "there") << "mine";
  const auto csv = export_csv(store_, session_, folder_ / "there");
  ASSERT_FALSE(csv);
  EXPECT_EQ(csv.error().code, ErrorCode::kAlreadyExists);
  const auto hdf5 = export_hdf5(store_, session_, folder_ / "there");
  ASSERT_FALSE(hdf5);
  EXPECT_EQ(hdf5.error().code, ErrorCode::kAlreadyExists);
  const auto xdf = export_xdf(store_, session_, folder_ / "there");
  ASSERT_FALSE(xdf);
  EXPECT_EQ(xdf.error().code, ErrorCode::kAlreadyExists);
}

}  // namespace
}  // namespace tonus::formats
