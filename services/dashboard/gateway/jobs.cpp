#include "services/dashboard/gateway/jobs.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>
#include <tuple>
#include <unistd.h>

#include "services/core/file_descriptor.hpp"
#include "services/core/id.hpp"
#include "services/core/json_text.hpp"
#include "services/core/name.hpp"
#include "services/core/process.hpp"
#include "services/core/text.hpp"
#include "services/core/text_file.hpp"

namespace tonus::dashboard {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kMostWaiting = 16;
constexpr std::size_t kLongestLine = 1000;
constexpr int kLookMs = 100;
constexpr std::chrono::seconds kPatience{2};
constexpr std::array<const char*, 4> kStates{"waiting", "running", "done", "failed"};

struct Format {
  const char* name;
  const char* extension;
  bool is_folder;
};
constexpr std::array<Format, 4> kFormats{
    {{"bids", ".tar", true}, {"csv", ".tar", true}, {"hdf5", ".h5", false}, {"xdf", ".xdf", false}}};

Error io(const std::string& what, const std::string& why) {
  return fail(ErrorCode::kIo, fmt::format("{} failed: {}", what, why));
}

Result<void> make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return io("making of folder " + folder.string(), error.message());
  return {};
}

json to_json(const Job& job) {
  return {{"number", job.number},   {"what", job.what},
          {"subject", job.subject}, {"state", kStates[static_cast<std::size_t>(job.state)]},
          {"done", job.done},       {"total", job.total},
          {"message", job.message}, {"path", job.path}};
}

std::optional<std::uint64_t> number_at(std::string_view& text) {
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

}  // namespace

std::optional<std::pair<std::uint64_t, std::uint64_t>> progress_in(std::string_view line) {
  const auto colon = line.find(": ");
  if (colon == std::string_view::npos) return std::nullopt;
  line.remove_prefix(colon + 2);
  const auto done = number_at(line);
  constexpr std::string_view kOf = " of ";
  if (!done || !line.starts_with(kOf)) return std::nullopt;
  line.remove_prefix(kOf.size());
  const auto total = number_at(line);
  if (!total) return std::nullopt;
  return std::pair(*done, *total);
}

Jobs::Jobs(JobFolders folders) : folders_(std::move(folders)), thread_([this] { run(); }) {}

Jobs::~Jobs() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

Result<std::uint64_t> Jobs::order_export(const std::string& session, const std::string& format) {
  const auto found =
      std::find_if(kFormats.begin(), kFormats.end(), [&](const Format& one) { return one.name == format; });
  if (found == kFormats.end()) {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("format: '{:.20}' is not allowed; expected bids, csv, hdf5 or xdf", shown(format)));
  }
  const auto id = id_from_hex(session);
  if (!id) return fail(ErrorCode::kInvalidArgument, "session: expected 32 hexadecimal digits");
  const std::string name = fmt::format("tonus-{}-{}", to_hex(*id).substr(0, 8), format);
  Order order;
  order.scratch = folders_.exports / (".part-" + name);
  order.made = order.scratch / (found->is_folder ? name : name + found->extension);
  order.kept = folders_.exports / (name + found->extension);
  order.is_packed = found->is_folder;
  order.words = {folders_.tonus.string(), "export",   to_hex(*id), "--archive",
                 folders_.store,          "--format", format,      "--out",
                 order.made.string()};
  const std::string path = "/exports/" + order.kept.filename().string();
  return add({0, "export", fmt::format("{} {}", to_hex(*id).substr(0, 8), format), JobState::kWaiting, 0, 0,
              "", path},
             std::move(order));
}

Result<std::uint64_t> Jobs::order_report(const std::string& name, const std::string& cohort) {
  if (const auto fault = fault_of_name(name); !fault.empty())
    return fail(ErrorCode::kInvalidArgument, "name: " + fault);
  std::error_code error;
  if (fs::exists(folders_.reports / name, error))
    return fail(ErrorCode::kAlreadyExists, fmt::format("name: there is a report '{}' already", name));
  Order order;
  order.scratch = folders_.exports / (".part-report-" + name);
  order.made = order.scratch / name;
  order.kept = folders_.reports / name;
  const fs::path file = order.scratch / "cohort.toml";
  TONUS_TRY(make_folder(order.scratch));
  TONUS_TRY(write_text_file(file, cohort));
  order.words = {folders_.tonus.string(), "report", "--archive",        folders_.store, "--cohort",
                 file.string(),           "--out",  order.made.string()};
  return add({0, "report", name, JobState::kWaiting, 0, 0, "", fmt::format("/reports/{}/index.html", name)},
             std::move(order));
}

Result<std::uint64_t> Jobs::add(Job job, Order order) {
  const std::lock_guard lock(mutex_);
  if (waiting_.size() >= kMostWaiting)
    return fail(ErrorCode::kUnavailable, fmt::format("{} jobs wait already", waiting_.size()));
  const bool is_same = std::any_of(jobs_.begin(), jobs_.end(), [&](const Job& known) {
    return known.path == job.path && (known.state == JobState::kWaiting || known.state == JobState::kRunning);
  });
  if (is_same) return fail(ErrorCode::kAlreadyExists, job.subject + " is being made already");
  job.number = jobs_.size() + 1;
  order.number = job.number;
  jobs_.push_back(std::move(job));
  waiting_.push_back(std::move(order));
  changed_.notify_all();
  return jobs_.back().number;
}

std::vector<Job> Jobs::list() const {
  const std::lock_guard lock(mutex_);
  return jobs_;
}

std::string Jobs::list_json() const {
  json all = json::array();
  for (const Job& job : list()) all.push_back(to_json(job));
  return json_text(all, -1);
}

void Jobs::run() {
  while (true) {
    Order order;
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return is_ending_ || !waiting_.empty(); });
      if (is_ending_) return;
      order = std::move(waiting_.front());
      waiting_.pop_front();
      jobs_[order.number - 1].state = JobState::kRunning;
    }
    const auto outcome = carry_out(order);
    std::error_code ignored;
    fs::remove_all(order.scratch, ignored);
    finish(order.number, outcome);
  }
}

Result<void> Jobs::carry_out(const Order& order) {
  std::error_code error;
  fs::remove_all(order.made, error);  // of a gateway that was killed
  TONUS_TRY(make_folder(order.scratch));
  TONUS_TRY(make_folder(order.kept.parent_path()));
  TONUS_TRY(execute(order, order.words));
  fs::path made = order.made;
  if (order.is_packed) {
    made = order.scratch / order.kept.filename();
    TONUS_TRY(execute(
        order, {"tar", "-cf", made.string(), "-C", order.scratch.string(), order.made.filename().string()}));
  }
  fs::rename(made, order.kept, error);
  if (error) return io("moving of " + made.string(), error.message());
  return {};
}

/// Reads what the program says, line by line, until it ends.
Result<void> Jobs::execute(const Order& order, const std::vector<std::string>& words) {
  std::array<int, 2> ends{-1, -1};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return io("a pipe", std::strerror(errno));
  FileDescriptor reading(ends[0]);
  FileDescriptor writing(ends[1]);
  TONUS_TRY_ASSIGN(auto child, ChildProcess::start(words, {writing.get(), {}, {}}));
  (void)writing.close();
  std::string last;
  std::string line;
  std::array<char, 4096> bytes{};
  while (true) {
    if (is_ending_) {
      (void)child.stop(kPatience);
      return fail(ErrorCode::kUnavailable, "the gateway ended");
    }
    pollfd waiting{reading.get(), POLLIN, 0};
    if (::poll(&waiting, 1, kLookMs) == 0) continue;
    const ssize_t got = ::read(reading.get(), bytes.data(), bytes.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) break;
    for (const char c : std::string_view(bytes.data(), static_cast<std::size_t>(got))) {
      if (c != '\n') {
        if (line.size() < kLongestLine) line.push_back(c);
      } else if (!line.empty()) {
        last = std::exchange(line, {});
        note(order.number, last);
      }
    }
  }
  const ProcessEnd end = child.wait();
  if (end.is_success()) return {};
  return fail(ErrorCode::kInternal, last.empty() ? fmt::format("{} {}", words[0], end.text()) : shown(last));
}

void Jobs::note(std::uint64_t number, const std::string& line) {
  const std::lock_guard lock(mutex_);
  Job& job = jobs_[number - 1];
  job.message = shown(line);
  if (const auto progress = progress_in(line)) std::tie(job.done, job.total) = *progress;
}

void Jobs::finish(std::uint64_t number, const Result<void>& outcome) {
  const std::lock_guard lock(mutex_);
  Job& job = jobs_[number - 1];
  job.state = outcome ? JobState::kDone : JobState::kFailed;
  if (outcome) {
    job.done = job.total;
  } else {
    job.message = outcome.error().message;
    job.path.clear();
    spdlog::warn("{} {}: {}", job.what, job.subject, job.message);
  }
}

}  // namespace tonus::dashboard
