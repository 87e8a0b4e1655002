// A simulated session, started, watched, paused, stopped, resumed and finished from the pages; and what they
// show is what the archive holds.

#include <arpa/inet.h>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <sys/socket.h>
#include <unistd.h>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/store/open_store.hpp"
#include "services/store/session_reader.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::testing {
namespace {

constexpr std::chrono::seconds kStartLimit{60};
constexpr std::chrono::seconds kSessionLimit{240};

/// A port that nobody uses now.
int free_port() {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  EXPECT_EQ(bind(socket, reinterpret_cast<sockaddr*>(&address), size), 0);
  EXPECT_EQ(getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size), 0);
  close(socket);
  return ntohs(address.sin_port);
}

using Row = std::map<std::string, std::string>;

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  for (const char c : line) {
    if (c == '"') {
      is_quoted = !is_quoted;
    } else if (c == ',' && !is_quoted) {
      fields.emplace_back();
    } else {
      fields.back().push_back(c);
    }
  }
  return fields;
}

/// A table that a page handed out.
std::vector<Row> table(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  const auto heads = fields_of(line);
  std::vector<Row> rows;
  while (std::getline(in, line)) {
    const auto fields = fields_of(line);
    Row row;
    for (std::size_t i = 0; i < std::min(heads.size(), fields.size()); ++i) row[heads[i]] = fields[i];
    rows.push_back(std::move(row));
  }
  return rows;
}

void expect_matrix(const Row& row, const std::string& name, const v1::MatrixEstimate& matrix) {
  constexpr const char* kElements[] = {"_xx", "_xy", "_yx", "_yy"};
  for (std::size_t i = 0; i < 4; ++i) {
    const auto head = name + kElements[i];
    EXPECT_EQ(std::stod(row.at(head)), matrix.value()[i]) << head;
    EXPECT_EQ(std::stod(row.at(head + "_se")), matrix.standard_error()[i]) << head;
    EXPECT_EQ(std::stod(row.at(head + "_low95")), matrix.low95()[i]) << head;
    EXPECT_EQ(std::stod(row.at(head + "_high95")), matrix.high95()[i]) << head;
  }
}

/// Every estimate of the archive is in the table, number by number, and nothing else is.
void expect_same(const std::vector<Row>& rows, const std::vector<v1::Estimate>& estimates) {
  ASSERT_FALSE(estimates.empty());
  ASSERT_EQ(rows.size(), estimates.size());
  for (const auto& estimate : estimates) {
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const Row& r) {
      return r.at("condition") == estimate.posture() && r.at("method") == estimate.method() &&
             r.at("model") == estimate.model();
    });
    ASSERT_NE(row, rows.end()) << estimate.posture() << " " << estimate.method();
    EXPECT_EQ(std::stoul(row->at("trials_used")), estimate.trials_used());
    expect_matrix(*row, "M_kg", estimate.mass_kg());
    expect_matrix(*row, "B_Ns_per_m", estimate.damping_Ns_per_m());
    expect_matrix(*row, "K_N_per_m", estimate.stiffness_N_per_m());
  }
}

/// What was said of trials and of the session on the page is in the archive: two rejections by hand, one
/// note.
void expect_remarks(store::Store& store, const Id& session, const nlohmann::json& seen) {
  std::map<std::uint32_t, std::string> reviews;
  std::vector<std::string> notes;
  const auto read = [&](const store::Message& message) -> Result<void> {
    if (message.topic == topics::kTrialReview.spec.name) {
      const auto review = bus::decode<v1::TrialReview>(*message.payload);
      if (review && review->is_rejected()) reviews[review->attempt()] = review->reason();
    }
    if (message.topic == topics::kSessionNote.spec.name) {
      if (const auto note = bus::decode<v1::SessionNote>(*message.payload)) notes.push_back(note->text());
    }
    return {};
  };
  ASSERT_TRUE(store.visit_messages({"", session, std::nullopt}, read));
  const std::map<std::uint32_t, std::string> wanted{{seen["rejected"], "coughed"},
                                                    {seen["repeated"], "repeat"}};
  EXPECT_EQ(reviews, wanted);
  EXPECT_EQ(notes, std::vector<std::string>{"light on"});
}

/// As `tonus report` leaves one in the data folder: a page with a figure. Its script must not run.
void write_report(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "index.html")
      << "<!doctype html><title>Pilot</title><h1>Pilot study</h1><img src=figure3.svg>"
         "<script>document.body.dataset.script = 'ran'</script>";
  std::ofstream(folder / "figure3.svg")
      << R"(<svg xmlns="http://www.w3.org/2000/svg" width="40" height="30"><rect width="40" height="30"/></svg>)";
}

TEST(SessionInBrowser, IsSteeredFromThePagesAndThePagesShowWhatTheArchiveHolds) {
  if (!std::filesystem::exists(TONUS_CHROMIUM))
    GTEST_SKIP() << "needs Chromium (Debian package chromium), and there is none";
  if (!std::filesystem::exists(std::filesystem::path(TONUS_WEB_FOLDER) / "node_modules"))
    GTEST_SKIP() << "needs the pages, which were not built (npm)";
  const TemporaryFolder folder;
  write_report(folder.path() / "data" / "reports" / "pilot");
  const std::string listen = "127.0.0.1:" + std::to_string(free_port());
  Process system(program("tonus"),
                 {"up", "--dashboard", "--dashboard-listen", listen, "--domain", std::to_string(own_domain()),
                  "--data", (folder / "data").string(), "--speed", "real", "--profile",
                  source_file("tests/browser/profile.toml").string()},
                 folder / "up.log");
  ASSERT_TRUE(system.wait_for_output("dashboard serves http://" + listen, kStartLimit)) << system.output();
  std::filesystem::create_directories(TONUS_SCREENSHOTS);
  Process browser(TONUS_NODE,
                  {TONUS_BROWSER_SCRIPT, TONUS_WEB_FOLDER, TONUS_CHROMIUM, "http://" + listen,
                   source_file("tests/browser/short.toml").string(), std::to_string(system.id()),
                   folder.path().string(), TONUS_SCREENSHOTS},
                  folder / "browser.log");
  ASSERT_EQ(browser.wait(kSessionLimit), 0) << browser.output() << system.output();
  std::printf("%s", browser.output().c_str());

  auto store = store::open_store_for_reading((folder.path() / "data" / "archive.sqlite").string());
  ASSERT_TRUE(store) << store.error().message;
  const auto record = store::find_session(**store, "last");
  ASSERT_TRUE(record) << record.error().message;
  const auto session = store::read_session(**store, record->session);
  ASSERT_TRUE(session) << session.error().message;
  const auto estimates = store::newest_estimates(*session);
  expect_same(table(folder / "live.csv"), estimates);
  expect_same(table(folder / "archive.csv"), estimates);

  std::ifstream seen_file(folder / "seen.json");
  const auto seen = nlohmann::json::parse(seen_file);
  EXPECT_EQ(seen["session"], to_hex(record->session));
  std::size_t judged = 0;
  for (const auto& trial : session->trials) judged += trial.verdict ? 1 : 0;
  EXPECT_EQ(seen["verdicts"], judged);
  ASSERT_TRUE(session->state);
  EXPECT_EQ(seen["counted"], session->state->counted());
  EXPECT_EQ(session->state->phase(), v1::SESSION_COMPLETED);
  expect_remarks(**store, record->session, seen);
}

}  // namespace
}  // namespace tonus::testing
