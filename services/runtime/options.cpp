#include "services/runtime/options.hpp"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>
#include <unistd.h>

#include "services/core/folder.hpp"
#include "services/core/name.hpp"
#include "services/core/places.hpp"
#include "services/core/standard_descriptors.hpp"
#include "services/core/text.hpp"
#include "services/runtime/configuration.hpp"
#include "services/runtime/option_documents.hpp"
#include "services/runtime/rigs.hpp"
#include "services/runtime/settings.hpp"
#include "services/runtime/usage.hpp"
#include "services/runtime/version.hpp"

namespace tonus::runtime {
namespace {

CLI::Option* add_config_option(CLI::App& app) {
  return app
      .add_option(
          "--config",
          "file of the options that are not given here, or none (default: /etc/tonus/tonus.toml, if it "
          "exists)")
      ->group(kCommonGroup)
      ->type_name("FILE")
      ->configurable(false);
}

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

/// Short forms of --log, for people at a terminal.
void add_verbosity(CLI::App& app, std::string& level) {
  const auto flag = [&](const std::string& names, const char* to, const char* what) {
    auto* option = app.add_flag_callback(
        names, [&level, to] { level = to; }, what);
    option->group(kCommonGroup)->configurable(false);
    return option;
  };
  auto* verbose = flag("-v,--verbose", "debug", "same as --log debug");
  flag("-q,--quiet", "error", "same as --log error: no progress, no warnings")->excludes(verbose);
}

}  // namespace

void add_common_options(CLI::App& app, CommonOptions& options) {
  const auto common = [](CLI::Option* option) { return option->group(kCommonGroup); };
  common(app.add_option("--domain", options.domain, "DDS domain, 0 to 232"))
      ->check(CLI::Range(0, 232))
      ->capture_default_str();
  common(app.add_option("--dds", options.dds, "DDS implementation: fastdds or cyclonedds"))
      ->check(CLI::IsMember({"fastdds", "cyclonedds"}))
      ->capture_default_str();
  common(app.add_option(
             "--rig", options.rig,
             "name of the rig: letters, digits, - and _; several rigs may share a network and a domain"))
      ->check(CLI::Validator([](const std::string& name) { return fault_of_name(name); }, ""))
      ->capture_default_str();
  add_data_option(app, options.data, "folder for everything that is kept");
  common(app.add_option("--interface", options.interface,
                        "network interface of the lab, by name or address (default: this machine only)"));
  common(app.add_option("--peers", options.peers,
                        "the lab's other hosts, by name or address, with commas between"))
      ->delimiter(',');
  common(
      app.add_option("--discovery-servers", options.discovery_servers,
                     "instead of peers, with fastdds: ADDRESS:PORT of `tonus discovery-server` (port 11811)"))
      ->delimiter(',');
  common(
      app.add_option("--security", options.security,
                     "folder of this host's certificates, made by `tonus pki issue` (default: no security)"));
  common(app.add_option("--log", options.log_level, "debug, info, warn or error"))
      ->check(CLI::IsMember({"debug", "info", "warn", "error"}))
      ->capture_default_str();
  add_verbosity(app, options.log_level);
  add_config_option(app)->each([&options](const std::string& file) { options.configuration_file = file; });
  app.set_version_flag("--version", kVersion);
  app.parse_complete_callback([&app, &options] { options.configuration = configuration_text(app); });
}

CLI::Option* add_data_option(CLI::App& app, std::string& data, const std::string& what) {
  return app.add_option("--data", data, what)->group(kCommonGroup);
}

void set_example(CLI::App& app, const std::string& command_line) {
  app.footer("Example:\n  " + command_line);
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

namespace {

/// The options that Settings looks for by itself, so that --help and the parser know them, too.
void add_settings_options(CLI::App& app) {
  if (app.get_option_no_throw("--config") == nullptr) (void)add_config_option(app);
  app.add_flag("--print-config")->group("")->configurable(false);
  for (CLI::App* sub : app.get_subcommands({})) {
    if (!sub->get_fallthrough()) add_settings_options(*sub);
  }
}

bool asks_only_for_help(const std::vector<std::string>& words) {
  return std::any_of(words.begin(), words.end(), [](const std::string& word) {
    return word == "--help" || word == "-h" || word == "--version";
  });
}

int refuse(const CLI::App& app, const std::string& message) {
  (void)report(app.get_name(), fail(ErrorCode::kInvalidArgument, message));
  return 2;
}

/// --print-document KIND: for the build of the packages and the documentation.
std::optional<int> print_document(const CLI::App& app, const std::vector<std::string>& words) {
  const auto kind = argument_of("print-document", words);
  if (!kind) return std::nullopt;
  const auto document = option_document(app, *kind);
  if (!document) return refuse(app, document.error().message);
  std::fputs(document->c_str(), stdout);
  return 0;
}

}  // namespace

int parse_command_line(CLI::App& app, int argc, char** argv) {
  if (const auto good = check_text(argc, argv); !good) {
    (void)report(app.get_name(), good.error());
    return 2;
  }
  const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  add_settings_options(app);
  if (const auto printed = print_document(app, words)) return *printed;
  const auto settings = Settings::apply(app, words);
  if (!settings && !asks_only_for_help(words)) return refuse(app, settings.error().message);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return end_program(app.get_name(), app.exit(success));
  } catch (const CLI::ParseError& error) {
    if (const auto unknown = unknown_word(app, words)) {
      std::fprintf(stderr, "%s\n", unknown->c_str());
    } else {
      std::fprintf(stderr, "%s: %s (--help lists what is allowed)\n", app.get_name().c_str(),
                   shown(error.what()).c_str());
    }
    return kRefused;
  }
  if (const auto good = settings->check(app); !good) return refuse(app, good.error().message);
  if (std::find(words.begin(), words.end(), "--print-config") != words.end()) {
    std::fputs(settings_text(settings->in_force(app)).c_str(), stdout);
    return 0;
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
  return absolute_path(folder);
}

Result<std::unique_ptr<bus::Bus>> open_bus(const CommonOptions& options, const std::string& program) {
  TONUS_TRY_ASSIGN(auto bus_options, bus_options_of(options, program));
  bus_options.partition = options.rig;
  return bus::create_bus(bus_options);
}

int report(const std::string& program, const Error& error) {
  // It may quote a damaged file or somebody's name for one.
  std::fprintf(stderr, "%s: %s\n", program.c_str(), shown(error.message).c_str());
  return error.message == kInterruptedText ? kInterrupted : kFailed;
}

}  // namespace tonus::runtime
