#include <algorithm>
#include <fstream>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <nlohmann/json.hpp>
#include <set>
#include <spdlog/fmt/fmt.h>

#include "services/core/crc32c.hpp"
#include "services/core/text.hpp"
#include "services/recording/dataset.hpp"
#include "tests/integration/archive_file.hpp"
#include "tests/integration/program_run.hpp"
#include "tests/support/process.hpp"

namespace tonus::testing {
namespace {

namespace fs = std::filesystem;

std::string content_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// Puts `by` in the place of `name`, of the same length, wherever it is in the batch.
void rename_in(store::Batch& batch, const std::string& name, const std::string& by) {
  ASSERT_EQ(name.size(), by.size());
  const auto replace = [&](auto& text) {
    auto at = text.begin();
    while ((at = std::search(at, text.end(), name.begin(), name.end())) != text.end())
      at = std::copy(by.begin(), by.end(), at);
  };
  for (auto& session : batch.sessions) replace(session.subject);
  for (auto& trial : batch.trials) replace(trial.posture);
  for (auto& message : batch.messages) {
    auto bytes = *message.payload;
    std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    replace(text);
    std::copy_n(reinterpret_cast<const std::byte*>(text.data()), text.size(), bytes.begin());
    message.payload = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
    message.checksum = crc32c(*message.payload);
  }
}

/// Nothing that is not UTF-8, no control character but the ends of lines, nothing that turns the direction.
bool is_harmless(const std::string& text) {
  return is_utf8(text) && masked(text, TextKind::kFile) == text && text.find('\r') == std::string::npos;
}

/// "sub-07" and "reference" as other programs could have written them: not UTF-8, an escape code, a line end,
/// a formula, a turn of the direction.
constexpr const char* kSubject = "\xFF\x1B[2J\n";
constexpr const char* kPosture = "=1+1\n\xE2\x80\xAE\"";

class ForeignText : public ::testing::Test {
 protected:
  static made_up::SessionRecipe spoiled() {
    auto recipe = made_up::unloaded_session();
    recipe.spoil_batch = [](store::Batch& batch) {
      rename_in(batch, "sub-07", kSubject);
      rename_in(batch, "reference", kPosture);
    };
    return recipe;
  }

  ProgramRun run(const std::vector<std::string>& arguments, const std::string& shell = "\"$@\"") {
    return run_program("tonus", arguments, folder_.path(), shell);
  }

  TemporaryFolder folder_;
};

TEST_F(ForeignText, InAnArchiveIsShownWithoutWhatSteersATerminal) {
  const ArchiveFile archive(spoiled());
  for (const std::string command : {"ls", "show", "verify"}) {
    const auto text = run({command, "--archive", archive.path()});
    EXPECT_EQ(text.code, 0) << command << ": " << text.errors;
    EXPECT_TRUE(is_harmless(text.output)) << command;
    const auto json = run({command, "--json", "--archive", archive.path()});
    EXPECT_EQ(json.code, 0) << command << ": " << json.errors;
    EXPECT_TRUE(is_harmless(json.output)) << command;
    EXPECT_TRUE(nlohmann::json::accept(json.output)) << command;
  }
  const auto lines = run({"ls", "--archive", archive.path()}).output;
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 2) << lines;
  const auto list = nlohmann::json::parse(run({"ls", "--json", "--archive", archive.path()}).output);
  EXPECT_EQ(list.at("sessions").at(0).at("subject"), "??[2J ");
  const auto identified = run({"identify", archive.path(), "--json", (folder_ / "results.json").string()});
  EXPECT_EQ(identified.code, 0) << identified.errors;
  EXPECT_TRUE(is_harmless(identified.output));
  EXPECT_TRUE(is_harmless(content_of(folder_ / "results.json")));
  EXPECT_NE(identified.output.find("=1+1 ???\""), std::string::npos) << identified.output;
}

TEST_F(ForeignText, InAnArchiveIsExportedWithoutWhatOtherProgramsWouldObey) {
  const ArchiveFile archive(spoiled());
  for (const std::string format : {"csv", "bids", "hdf5"}) {
    const auto out = folder_ / format;
    const auto exported =
        run({"export", "--archive", archive.path(), "--format", format, "--out", out.string()});
    ASSERT_EQ(exported.code, 0) << format << ": " << exported.errors;
    if (format == "hdf5") continue;
    for (const auto& entry : fs::recursive_directory_iterator(out)) {
      EXPECT_TRUE(is_harmless(entry.path().string()));
      if (!entry.is_regular_file()) continue;
      const std::string text = content_of(entry.path());
      EXPECT_TRUE(is_harmless(text)) << entry.path();
      if (entry.path().extension() == ".csv") {
        EXPECT_EQ(text.find("\n="), std::string::npos) << entry.path();
        EXPECT_EQ(text.find(",="), std::string::npos) << entry.path();
        EXPECT_EQ(text.find("\"="), std::string::npos) << entry.path();
      }
    }
  }
  EXPECT_NE(content_of(folder_ / "csv" / "estimates.csv").find("\"'=1+1 ???\"\"\""), std::string::npos);
  EXPECT_TRUE(recording::read_dataset(folder_ / "bids"));
  const hid_t file = H5Fopen((folder_ / "hdf5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  const hid_t attribute = H5Aopen(file, "subject", H5P_DEFAULT);
  char* subject = nullptr;
  const hid_t type = H5Aget_type(attribute);
  ASSERT_GE(H5Aread(attribute, type, &subject), 0);
  EXPECT_STREQ(subject, "??[2J ");
  H5free_memory(subject);
  H5Tclose(type);
  H5Aclose(attribute);
  H5Fclose(file);
}

TEST_F(ForeignText, OfNamesBecomesLabelsThatAreDistinctAndValid) {
  std::set<std::string> labels;
  for (const std::string name : {"P 01 ", "P-01 ", "P_01 ", "\xE5\xB1\xB1 1", "\xE5\xB1\xB1 2"}) {
    auto recipe = made_up::unloaded_session();
    recipe.spoil_batch = [&](store::Batch& batch) { rename_in(batch, "sub-07", name + " "); };
    const ArchiveFile archive(std::move(recipe));
    const auto out = folder_ / fmt::format("dataset{}", labels.size());
    const auto exported =
        run({"export", "--archive", archive.path(), "--format", "bids", "--out", out.string()});
    ASSERT_EQ(exported.code, 0) << exported.errors;
    for (const auto& entry : fs::directory_iterator(out)) {
      const std::string folder = entry.path().filename().string();
      if (!folder.starts_with("sub-")) continue;
      EXPECT_TRUE(std::all_of(folder.begin() + 4, folder.end(), [](unsigned char c) {
        return std::isalnum(c) != 0 && c < 0x80;
      })) << folder;
      labels.insert(folder);
    }
  }
  EXPECT_EQ(labels.size(), 5U);
}

TEST_F(ForeignText, IsRefusedOnTheCommandLineAndInTheEnvironment) {
  const std::string bad = "M\xFCller\n\x1B[2J";
  const std::vector<std::vector<std::string>> commands{
      {"run", "--subject", bad, "p.toml"},
      {"ls", "--archive", bad},
      {"ls", "--data", bad},
      {"identify", bad},
      {"demo", "--subject=" + bad},
      {"import", bad},
      {bad},
      {"up", "--rig", bad},
      {"recover", "a", "--out", bad},
  };
  for (const auto& command : commands) {
    const auto refused = run(command);
    EXPECT_TRUE(is_refused_in_one_line(refused)) << command[0] << ": " << refused.errors;
    EXPECT_NE(refused.errors.find("is not UTF-8"), std::string::npos) << refused.errors;
    EXPECT_TRUE(is_harmless(refused.errors)) << command[0];
  }
  for (const std::string variable : {"TONUS_DATA", "TONUS_RIG"}) {
    const auto refused = run({"ls"}, "env " + variable + "=\"$(printf 'a\\377')\" \"$@\"");
    EXPECT_TRUE(is_refused_in_one_line(refused)) << variable << ": " << refused.errors;
    EXPECT_NE(refused.errors.find("is not UTF-8"), std::string::npos) << refused.errors;
  }
}

TEST_F(ForeignText, InFilesIsRefusedInOneLine) {
  std::ofstream(folder_ / "protocol.toml") << "schema = 1\nkind = \"unloaded\"\nname = \"M\xFCller\"\n";
  std::ofstream(folder_ / "profile.toml") << "[subject]\nname = \"M\xFCller\"\n";
  const auto unloaded = source_file("deploy/protocols/unloaded.toml").string();
  const std::vector<std::vector<std::string>> commands{
      {"run", "--dry-run", (folder_ / "protocol.toml").string()},
      {"demo", (folder_ / "protocol.toml").string()},
      {"demo", unloaded, "--profile", (folder_ / "profile.toml").string(), "--data",
       (folder_ / "data").string(), "--domain", std::to_string(own_domain())},
      {"report", "--cohort", (folder_ / "profile.toml").string()},
  };
  for (const auto& command : commands) {
    const auto refused = run(command);
    EXPECT_TRUE(is_refused_in_one_line(refused)) << command[0] << ": " << refused.errors;
    EXPECT_TRUE(is_harmless(refused.errors)) << command[0] << ": " << refused.errors;
    EXPECT_NE(refused.errors.find(".toml"), std::string::npos) << refused.errors;
  }
}

TEST_F(ForeignText, InNamesOfFilesDoesNotReachATerminal) {
  for (const std::string name : {"a\nb", "\x1B[2J",
                                 "a\xE2\x80\xAE"
                                 "b"}) {
    const auto path = (folder_ / name).string();
    for (const auto& command : std::vector<std::vector<std::string>>{
             {"ls", "--archive", path}, {"identify", path}, {"import", path}, {"run", "--dry-run", path}}) {
      const auto refused = run(command);
      EXPECT_TRUE(is_refused_in_one_line(refused)) << command[0] << ": " << refused.errors;
      EXPECT_TRUE(is_harmless(refused.errors)) << command[0];
    }
  }
}

}  // namespace
}  // namespace tonus::testing
