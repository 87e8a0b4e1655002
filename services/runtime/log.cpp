#define SD_JOURNAL_SUPPRESS_LOCATION  // of this file, not of what is logged
#include "services/runtime/log.hpp"

#include <array>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <syslog.h>
#include <systemd/sd-journal.h>
#include <unistd.h>

#include "services/core/text.hpp"
#include "services/runtime/options.hpp"

namespace tonus::runtime {
namespace {

int priority_of(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::trace:
    case spdlog::level::debug:
      return LOG_DEBUG;
    case spdlog::level::warn:
      return LOG_WARNING;
    case spdlog::level::err:
      return LOG_ERR;
    case spdlog::level::critical:
      return LOG_CRIT;
    default:
      return LOG_INFO;
  }
}

/// A line's text. Names and paths in it cannot steer a terminal or fake another line.
std::string text_of(const spdlog::details::log_msg& message) {
  return shown({message.payload.data(), message.payload.size()});
}

/// "%v" of a line.
class ShownText : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&, spdlog::memory_buf_t& line) override {
    const std::string text = text_of(message);
    line.append(text.data(), text.data() + text.size());
  }
  [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<ShownText>();
  }
};

/// spdlog has a sink for the journal, but none with fields of one's own.
class JournalSink : public spdlog::sinks::base_sink<std::mutex> {
 public:
  JournalSink(std::string program, std::string rig, std::string domain)
      : program_(std::move(program)), rig_(std::move(rig)), domain_(std::move(domain)) {}

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    (void)sd_journal_send("MESSAGE=%s", text_of(message).c_str(), "PRIORITY=%d", priority_of(message.level),
                          "SYSLOG_IDENTIFIER=%s", program_.c_str(), "TONUS_RIG=%s", rig_.c_str(),
                          "TONUS_DOMAIN=%s", domain_.c_str(), nullptr);
  }
  void flush_() override {}

  std::string program_;
  std::string rig_;
  std::string domain_;
};

constexpr int kToDebug = 22;
constexpr int kBack = 23;

/// What the signals set; spdlog keeps a level in an atomic, so that a handler may write it.
std::atomic<spdlog::logger*> signalled_logger{nullptr};
std::atomic<int> usual_level{spdlog::level::info};

void change_level(int number) {
  auto* logger = signalled_logger.load(std::memory_order_acquire);  // pairs with the store in start()
  if (logger == nullptr) return;
  const bool is_debug = number == SIGRTMIN + kToDebug;
  logger->set_level(is_debug ? spdlog::level::debug
                             : static_cast<spdlog::level::level_enum>(usual_level.load()));
}

void listen_to_signals() {
  struct sigaction action {};
  action.sa_handler = change_level;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGRTMIN + kToDebug, &action, nullptr);
  sigaction(SIGRTMIN + kBack, &action, nullptr);
}

void start(const std::string& program, const std::string& level, spdlog::sink_ptr sink) {
  auto logger = std::make_shared<spdlog::logger>(program, std::move(sink));
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<ShownText>('v').set_pattern("%Y-%m-%d %H:%M:%S.%e %z %^%l%$ %n: %v");
  logger->set_formatter(std::move(formatter));
  logger->set_level(spdlog::level::from_str(level));
  usual_level = logger->level();
  spdlog::set_default_logger(logger);
  signalled_logger.store(logger.get(), std::memory_order_release);
  listen_to_signals();
}

/// In colour on a terminal, unless NO_COLOR is set (https://no-color.org).
spdlog::sink_ptr standard_error() {
  const char* without = std::getenv("NO_COLOR");
  const bool has_colour = without == nullptr || *without == '\0';
  return std::make_shared<spdlog::sinks::stderr_color_sink_mt>(has_colour ? spdlog::color_mode::automatic
                                                                          : spdlog::color_mode::never);
}

}  // namespace

bool is_logged_by_journal() {
  const char* stream = std::getenv("JOURNAL_STREAM");
  struct stat status {};
  if (stream == nullptr || fstat(STDERR_FILENO, &status) != 0) return false;
  return fmt::format("{}:{}", status.st_dev, status.st_ino) == stream;
}

void start_log(const std::string& program, const CommonOptions& options) {
  auto sink = is_logged_by_journal()
                  ? std::make_shared<JournalSink>(program, options.rig, std::to_string(options.domain))
                  : standard_error();
  start(program, options.log_level, std::move(sink));
}

void start_log(const std::string& program, const std::string& level) {
  start(program, level, standard_error());
}

}  // namespace tonus::runtime
