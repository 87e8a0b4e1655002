// The manual: its links lead somewhere, its commands run, and its tables say what the programs write.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tests/integration/program_run.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::testing {
namespace {

namespace fs = std::filesystem;
using Names = std::set<std::string>;
using ::testing::ContainsRegex;

constexpr std::chrono::seconds kLimit{240};
const fs::path kManual = source_file("docs/manual");
const fs::path kArchive = source_file("tests/acceptance/recorded_session/session.sqlite");

std::string content_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::vector<fs::path> pages(const fs::path& folder, const char* extension) {
  std::vector<fs::path> all;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == extension) all.push_back(entry.path());
  }
  std::sort(all.begin(), all.end());
  return all;
}

struct Snippet {
  std::string mark;  ///< What follows the opening fence: "sh run".
  std::string text;
};

std::vector<Snippet> snippets_of(const fs::path& page) {
  std::vector<Snippet> snippets;
  std::istringstream lines(content_of(page));
  bool is_inside = false;
  std::size_t indented = 0;  // in a list's item
  for (std::string line; std::getline(lines, line);) {
    const auto begin = std::min(line.find_first_not_of(' '), line.size());
    if (line.compare(begin, 3, "```") == 0) {
      is_inside = !is_inside;
      indented = begin;
      if (is_inside) snippets.push_back({line.substr(begin + 3), ""});
    } else if (is_inside) {
      snippets.back().text += line.substr(std::min(indented, begin)) + "\n";
    }
  }
  EXPECT_FALSE(is_inside) << page << ": a fence is not closed";
  return snippets;
}

TEST(Manual, MarksEverySnippetAsOneThatTheTestsRun) {
  int snippets = 0;
  for (const auto& page : pages(kManual, ".md")) {
    for (const auto& snippet : snippets_of(page)) {
      ++snippets;
      EXPECT_EQ(snippet.mark, "sh run") << page << ":\n" << snippet.text;
    }
    std::istringstream lines(content_of(page));
    for (std::string line; std::getline(lines, line);)
      EXPECT_FALSE(line.starts_with("    ")) << page << ": indented code is not run: " << line;
  }
  EXPECT_GT(snippets, 5);
}

bool succeeds(const std::string& command) {
  const TemporaryFolder folder;
  Process shell("/bin/sh", {"-c", command}, folder / "output");
  return shell.wait(kLimit) == 0;
}

/// What the snippets of a page are run with: the programs, and a home of their own.
/// Debian's programs come before others of the machine: the Python module is built for its python3.
std::string beginning_of_script(const TemporaryFolder& folder) {
  fs::create_directory(folder / "work");
  fs::create_directory_symlink(source_file("deploy"), folder / "work" / "deploy");
  const std::string build = program("tonus").parent_path().parent_path().string();
  return "set -eu\ncd '" + (folder / "work").string() + "'\nexport PATH='" + build +
         "/bin':/usr/bin:\"$PATH\" PYTHONPATH='" + build + "/python' SOURCE='" + source_file(".").string() +
         "' HOME='" + folder.path().string() + "' XDG_DATA_HOME='" + (folder / "data").string() +
         "' TONUS_DOMAIN=" + std::to_string(own_domain()) + "\n";
}

TEST(Manual, RunsEverySnippetOfEveryPage) {
  for (const auto& page : pages(kManual, ".md")) {
    const TemporaryFolder folder;
    std::string script = beginning_of_script(folder);
    const auto snippets = snippets_of(page);
    if (snippets.empty()) continue;
    for (const auto& snippet : snippets) script += snippet.text;
    std::ofstream(folder / "script") << script;
    Process shell("/bin/sh", {(folder / "script").string()}, folder / "output");
    EXPECT_EQ(shell.wait(kLimit), 0) << page << ":\n" << script << shell.output();
  }
}

/// The other pages: in `sh run` and `python run` are commands that are run here; `sh HOST`, in the lab's
/// guide, is run by tests/packages/follow-the-guide; `sh network` in a network of its own; `toml PROGRAM` are
/// keys of that program's configuration; of `matlab`, which no package of Debian has, the names are checked.
class Docs : public ::testing::Test {
 protected:
  static std::vector<Snippet> marked(const fs::path& page, const std::string& mark) {
    auto snippets = snippets_of(page);
    std::erase_if(snippets, [&](const Snippet& snippet) { return snippet.mark != mark; });
    return snippets;
  }
  static inline const std::vector<fs::path> pages_ = pages(source_file("docs"), ".md");
};

TEST_F(Docs, MarkEverySnippetAsOneThatTheTestsRunOrCheck) {
  const Names of_this{"sh run", "python run", "sh network", "matlab"};
  const Names of_the_guide{"sh all", "sh rig", "sh server", "sh desk"};
  int snippets = 0;
  for (const auto& page : pages_) {
    for (const auto& snippet : snippets_of(page)) {
      ++snippets;
      const bool is_guides = page.filename() == "lab.md" && of_the_guide.contains(snippet.mark);
      EXPECT_TRUE(is_guides || of_this.contains(snippet.mark) || snippet.mark.starts_with("toml tonus"))
          << page << ": " << snippet.mark << "\n"
          << snippet.text;
    }
    std::istringstream lines(content_of(page));
    for (std::string line; std::getline(lines, line);)
      EXPECT_FALSE(line.starts_with("    ")) << page << ": indented code is not run: " << line;
  }
  EXPECT_GT(snippets, 25);
}

TEST_F(Docs, RunEveryCommandAndEveryLineOfPython) {
  const bool has_python = fs::exists(program("tonus").parent_path().parent_path() / "python" / "tonus") &&
                          succeeds("/usr/bin/python3 -c 'import numpy, pandas'");
  for (const auto& page : pages_) {
    const TemporaryFolder folder;
    std::string script = beginning_of_script(folder);
    int count = 0;
    for (const auto& snippet : snippets_of(page)) {
      if (snippet.mark == "sh run") script += snippet.text;
      if (snippet.mark == "python run" && has_python)
        script += "python3 - <<'END'\n" + snippet.text + "END\n";
      count += snippet.mark.ends_with(" run") ? 1 : 0;
    }
    if (count == 0) continue;
    std::ofstream(folder / "script") << script;
    Process shell("/bin/sh", {(folder / "script").string()}, folder / "output");
    EXPECT_EQ(shell.wait(kLimit), 0) << page << ":\n" << script << shell.output();
  }
  if (!has_python)
    GTEST_SKIP() << "the lines of Python were not run: python3-numpy and python3-pandas are missing";
}

constexpr std::string_view kOwnDriver = "/usr/local/lib/my_rig.so";  // of docs/lab.md's reader

TEST_F(Docs, NameKeysThatTheProgramsTake) {
  int count = 0;
  for (const auto& page : pages_) {
    for (const auto& snippet : snippets_of(page)) {
      if (!snippet.mark.starts_with("toml ")) continue;
      const TemporaryFolder folder;
      // A rig's own file stands beside that of its host.
      const bool is_of_rig = snippet.text.starts_with("[agent]");
      const fs::path file = is_of_rig ? folder / "rigs" / "rig.toml" : folder / "keys.toml";
      fs::create_directories(file.parent_path());
      std::ofstream(folder / "keys.toml") << "";
      std::string text = snippet.text;
      if (const auto at = text.find(kOwnDriver); at != std::string::npos) {
        text.replace(at, kOwnDriver.size(), (folder / "my_rig.so").string());
        std::ofstream(folder / "my_rig.so") << "";
      }
      std::ofstream(file) << text;
      const auto run = run_program(snippet.mark.substr(5),
                                   {"--print-config", "--config", folder / "keys.toml"}, folder.path());
      EXPECT_EQ(run.code, 0) << page << ": " << run.errors;
      std::istringstream lines(snippet.text);
      for (std::string line; std::getline(lines, line);) {
        const auto equals = line.find(" = ");
        if (equals == std::string::npos) continue;
        EXPECT_THAT(run.output,
                    ContainsRegex(line.substr(0, equals) + " = .*" + file.filename().string() + ":"))
            << page;
        ++count;
      }
    }
  }
  EXPECT_GT(count, 5);
}

TEST_F(Docs, NameAFirewallsRuleThatNftTakes) {
  if (!succeeds("unshare --net true && command -v nft"))
    GTEST_SKIP() << "needs nft (package nftables) and the right to make a network";
  int count = 0;
  for (const auto& page : pages_) {
    for (const auto& snippet : marked(page, "sh network")) {
      ++count;
      const TemporaryFolder folder;
      std::ofstream(folder / "script")
          << "set -e\nnft add table inet filter\n"
             "nft add chain inet filter input '{ type filter hook input priority 0; }'\n"
          << snippet.text << "nft list ruleset\n";
      Process shell("/usr/bin/unshare", {"--net", "/bin/sh", (folder / "script").string()},
                    folder / "output");
      EXPECT_EQ(shell.wait(kLimit), 0) << shell.output();
    }
  }
  EXPECT_GT(count, 0);
}

TEST_F(Docs, NameWhatAnExportForMatlabHas) {
  const TemporaryFolder folder;
  fs::copy(kArchive, folder / "session.sqlite");
  const auto file = folder / "session.h5";
  ASSERT_EQ(run_program("tonus",
                        {"export", "--archive", folder / "session.sqlite", "--format", "hdf5", "--out", file},
                        folder.path())
                .code,
            0);
  const hid_t opened = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(opened, 0);
  int count = 0;
  for (const auto& page : pages_) {
    for (const auto& snippet : marked(page, "matlab")) {
      for (auto at = snippet.text.find("'/"); at != std::string::npos; at = snippet.text.find("'/", at + 1)) {
        const auto path = snippet.text.substr(at + 1, snippet.text.find('\'', at + 1) - at - 1);
        const hid_t dataset = H5Dopen2(opened, path.c_str(), H5P_DEFAULT);
        EXPECT_GE(dataset, 0) << path;
        if (dataset >= 0) {
          EXPECT_GT(H5Aexists(dataset, "units"), 0) << path;
          H5Dclose(dataset);
        }
        ++count;
      }
    }
  }
  H5Fclose(opened);
  EXPECT_GT(count, 2);
}

/// The values of an attribute in a page.
Names attributes(const std::string& html, const std::string& name) {
  Names found;
  const std::string open = " " + name + "=\"";
  for (auto at = html.find(open); at != std::string::npos; at = html.find(open, at)) {
    at += open.size();
    found.insert(html.substr(at, html.find('"', at) - at));
  }
  return found;
}

class BuiltManual : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(built_ / "index.html"))
      GTEST_SKIP() << "the manual is not built: pandoc is not installed";
  }
  const fs::path built_ = program("tonus").parent_path().parent_path() / "share" / "tonus" / "manual";
};

TEST_F(BuiltManual, LinksOnlyToWhatExists) {
  int links = 0;
  for (const auto& page : pages(built_, ".html")) {
    const std::string html = content_of(page);
    Names targets = attributes(html, "href");
    targets.merge(attributes(html, "src"));
    for (const auto& target : targets) {
      if (target.find("://") != std::string::npos) continue;
      ++links;
      const auto hash = target.find('#');
      const auto file = target.substr(0, hash).empty() ? page : built_ / target.substr(0, hash);
      ASSERT_TRUE(fs::exists(file)) << page.filename() << " links to " << target;
      if (hash == std::string::npos) continue;
      EXPECT_TRUE(attributes(content_of(file), "id").contains(target.substr(hash + 1)))
          << page.filename() << " links to " << target;
    }
  }
  EXPECT_GT(links, 100);
}

TEST_F(BuiltManual, IsReachableFromItsFirstPageAndNeedsNoScriptAndNoNetwork) {
  Names reached{"index.html"};
  for (const auto& target : attributes(content_of(built_ / "index.html"), "href")) reached.insert(target);
  for (const auto& target : attributes(content_of(built_ / "formats.html"), "href")) reached.insert(target);
  for (const auto& page : pages(built_, ".html")) {
    EXPECT_TRUE(reached.contains(page.filename().string())) << page;
    const std::string html = content_of(page);
    EXPECT_EQ(html.find("<script"), std::string::npos) << page;
    EXPECT_EQ(html.find(" style=\""), std::string::npos) << page << ": the gateway's policy refuses it";
    for (const auto& target : attributes(html, "src"))
      EXPECT_EQ(target.find("://"), std::string::npos) << target;
  }
  EXPECT_NE(content_of(built_ / "numbers.html").find("<math"), std::string::npos);
}

/// "a.b", "c[].d" of every value; a list of values is one key.
void add_keys(Names& keys, const nlohmann::json& json, const std::string& path) {
  if (json.is_object()) {
    for (const auto& [key, value] : json.items())
      add_keys(keys, value, path.empty() ? key : path + "." + key);
  } else if (json.is_array() && !json.empty() && json.front().is_object()) {
    for (const auto& element : json) add_keys(keys, element, path + "[]");
  } else {
    keys.insert(path);
  }
}

/// The first column of the table below a heading of the second level.
Names documented(const std::string& heading) {
  Names keys;
  std::istringstream lines(content_of(kManual / "json.md"));
  bool is_there = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("## ")) is_there = line == "## " + heading;
    if (is_there && line.starts_with("| `")) keys.insert(line.substr(3, line.find('`', 3) - 3));
  }
  return keys;
}

class ManualsJson : public ::testing::Test {
 protected:
  void SetUp() override { fs::copy(kArchive, archive()); }
  [[nodiscard]] fs::path archive() const { return folder_ / "session.sqlite"; }

  [[nodiscard]] nlohmann::json printed(const std::vector<std::string>& words) const {
    return nlohmann::json::parse(run_program("tonus", words, folder_.path()).output);
  }

  /// The keys of an answer, those of its conditions apart.
  static void expect_documented(const nlohmann::json& json, const std::string& heading) {
    Names keys;
    add_keys(keys, json, "");
    EXPECT_EQ(keys, documented(heading)) << heading;
  }

  TemporaryFolder folder_;
};

TEST_F(ManualsJson, HasEveryKeyThatTheProgramsPrintAndNoOther) {
  expect_documented(printed({"ls", "--json", "--archive", archive()}), "tonus ls");
  expect_documented(printed({"verify", "--json", "--archive", archive()}), "tonus verify");
  expect_documented(printed({"explain", "--json"}), "tonus explain");
  auto shown = printed({"show", "--json", "--archive", archive()});
  nlohmann::json conditions = shown["conditions"];
  shown.erase("conditions");
  expect_documented(shown, "tonus show");
  const auto file = folder_ / "identified.json";
  ASSERT_EQ(run_program("tonus", {"identify", archive(), "--json", file.string()}, folder_.path()).code, 0);
  for (const auto& condition : nlohmann::json::parse(content_of(file))["conditions"])
    conditions.push_back(condition);
  Names keys;
  for (const auto& condition : conditions) add_keys(keys, condition, "");
  EXPECT_EQ(keys, documented("A condition"));
}

TEST_F(ManualsJson, HasEveryKeyThatCommandsPrintOfWhatTheyDid) {
  const auto in = [&](const char* name) { return (folder_ / name).string(); };
  const std::string archive = this->archive().string();
  expect_documented(
      printed({"export", "--json", "--archive", archive, "--format", "bids", "--out", in("bids")}),
      "tonus export");
  expect_documented(printed({"import", in("bids"), "--json", "--archive", in("imported.sqlite")}),
                    "tonus import");
  expect_documented(printed({"copy", in("copy.sqlite"), "--json", "--archive", archive}), "tonus copy");
  expect_documented(printed({"backup", in("backup.sqlite"), "--json", "--archive", archive}), "tonus backup");
  expect_documented(printed({"restore", in("backup.sqlite"), "--json", "--archive", in("restored.sqlite")}),
                    "tonus backup");
  expect_documented(printed({"recover", archive, "--json", "--out", in("recovered.sqlite")}),
                    "tonus recover");
  const auto session = printed({"ls", "--json", "--archive", archive})["sessions"][0]["session"];
  auto prune = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"prune", "--json", "--session", session, "--archive", in("copy.sqlite")});
    return printed(more);
  };
  EXPECT_EQ(prune({})["is_done"], false);
  const auto pruned = prune({"--yes"});
  EXPECT_EQ(pruned["sessions_left"], 0);
  expect_documented(pruned, "tonus prune");
  EXPECT_EQ(printed({"pki", "init", "--json", "--dds", "fastdds", "--authority", in("pki")})["dds"],
            "fastdds");
  EXPECT_EQ(printed({"pki", "issue", "desk", "--json", "--role", "viewer", "--authority", in("pki")})["host"],
            "desk");
  expect_documented(printed({"pki", "list", "--json", "--authority", in("pki")}), "tonus pki");
  EXPECT_EQ(printed({"pki", "renew", "--json", "--authority", in("pki")})["renewed"], 1);
  EXPECT_EQ(printed({"pki", "revoke", "desk", "--json", "--authority", in("pki")})["revoked"], 2);
}

TEST_F(ManualsJson, IsAloneOnStandardOutputWhereTheResultsFileIsADash) {
  const auto run = run_program("tonus", {"identify", archive(), "--json", "-"}, folder_.path());
  ASSERT_EQ(run.code, 0) << run.errors;
  const auto json = nlohmann::json::parse(run.output);
  EXPECT_FALSE(json["conditions"].empty());
  EXPECT_NE(run.errors.find("ellipse"), std::string::npos) << "the text is on standard error";
  const auto dashless = folder_ / "results.json";
  ASSERT_EQ(run_program("tonus", {"identify", archive(), "--json", dashless.string()}, folder_.path()).code,
            0);
  EXPECT_EQ(content_of(dashless), run.output);
}

}  // namespace
}  // namespace tonus::testing
