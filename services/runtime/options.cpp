#include "services/runtime/options.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <spdlog/fmt/fmt.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include "services/core/places.hpp"
#include "services/core/standard_descriptors.hpp"
#include "services/core/text.hpp"
#include "services/runtime/configuration.hpp"
#include "services/runtime/version.hpp"

namespace tonus::runtime {
namespace {

/// The program's words, and the variables that it reads.
Result<void> check_text(int argc, char** argv) {
  const auto refuse = [](const std::string& what, std::string_view value) {
    return fail(ErrorCode::kInvalidArgument, fmt::format("{}: '{}' is not UTF-8", what, shown(value)));
  };
  for (int i = 1; i < argc; ++i) {
    if (!is_utf8(argv[i])) return refuse(fmt::format("word {} of the command line", i), argv[i]);
  }
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text = *variable;
    if (text.starts_with("TONUS_") && !is_utf8(text)) return refuse("environment", text);
  }
  return {};
}

/// "%v" of a log line: names and paths in it cannot steer a terminal or fake another line.
class ShownText : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&, spdlog::memory_buf_t& line) override {
    const std::string text = shown({message.payload.data(), message.payload.size()});
    line.append(text.data(), text.data() + text.size());
  }
  [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<ShownText>();
  }
};

}  // namespace

void add_common_options(CLI::App& app, CommonOptions& options) {
  app.add_option("--domain", options.domain, "DDS domain, 0 to 232")
      ->envname("TONUS_DOMAIN")
      ->check(CLI::Range(0, 232))
      ->capture_default_str();
  app.add_option("--dds", options.dds, "DDS implementation: fastdds or cyclonedds")
      ->envname("TONUS_DDS")
      ->check(CLI::IsMember({"fastdds", "cyclonedds"}))
      ->capture_default_str();
  app.add_option("--rig", options.rig, "name of the rig")->envname("TONUS_RIG")->capture_default_str();
  app.add_option("--data", options.data, "folder for everything that is kept")->envname("TONUS_DATA");
  app.add_option(
         "--network", options.network,
         "address of this machine's interface, then of each peer, for a lab network (default: this machine "
         "only)")
      ->expected(1, 64);
  app.add_option("--log", options.log_level, "debug, info, warn or error")
      ->check(CLI::IsMember({"debug", "info", "warn", "error"}))
      ->capture_default_str();
  app.set_version_flag("--version", kVersion);
  app.parse_complete_callback([&app, &options] { options.configuration = configuration_text(app); });
}

void begin_program() {
  occupy_standard_descriptors();
  constexpr mode_t kOthers = S_IWGRP | S_IRWXO;
  ::umask(::umask(kOthers) | kOthers);
}

int end_program(const std::string& program, int code) {
  const auto finished = finish_standard_output();
  return finished || code != 0 ? code : report(program, finished.error());
}

int parse_command_line(CLI::App& app, int argc, char** argv) {
  if (const auto good = check_text(argc, argv); !good) {
    report(app.get_name(), good.error());
    return 2;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return end_program(app.get_name(), app.exit(success));
  } catch (const CLI::ParseError& error) {
    std::fprintf(stderr, "%s: %s (--help lists what is allowed)\n", app.get_name().c_str(),
                 shown(error.what()).c_str());
    return 2;
  }
  return -1;
}

Result<std::filesystem::path> data_folder(const CommonOptions& options) {
  std::filesystem::path folder = options.data;
  if (folder.empty()) {
    TONUS_TRY_ASSIGN(folder, default_data_folder());
  }
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return fail(ErrorCode::kIo, fmt::format("--data {}: {}; a folder that can be written is needed",
                                            folder.string(), error.message()));
  }
  return std::filesystem::absolute(folder);
}

Result<std::unique_ptr<bus::Bus>> open_bus(const CommonOptions& options, const std::string& program) {
  auto vendor = bus::parse_vendor(options.dds);
  if (!vendor) return vendor.error();
  bus::BusOptions bus_options;
  bus_options.vendor = *vendor;
  bus_options.domain = options.domain;
  bus_options.participant_name = program;
  if (!options.network.empty()) {
    bus_options.network.interface_address = options.network.front();
    bus_options.network.peers.assign(options.network.begin() + 1, options.network.end());
    bus_options.network.peers.push_back(options.network.front());
  }
  return bus::create_bus(bus_options);
}

int report(const std::string& program, const Error& error) {
  // It may quote a damaged file or somebody's name for one.
  std::fprintf(stderr, "%s: %s\n", program.c_str(), shown(error.message).c_str());
  return 1;
}

void start_log(const std::string& program, const std::string& level) {
  auto logger = spdlog::stderr_color_mt(program);
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<ShownText>('v').set_pattern("%H:%M:%S.%e %^%l%$ %n: %v");
  logger->set_formatter(std::move(formatter));
  logger->set_level(spdlog::level::from_str(level));
  spdlog::set_default_logger(logger);
}

}  // namespace tonus::runtime
