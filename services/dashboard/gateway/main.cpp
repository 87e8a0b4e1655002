// tonus-dashboard: from the bus to browsers and to tools that speak the Foxglove WebSocket protocol.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>
#include <string>

#include "services/core/installation.hpp"
#include "services/core/lifetime.hpp"
#include "services/core/name.hpp"
#include "services/dashboard/gateway/bus_reader.hpp"
#include "services/dashboard/gateway/desk_thread.hpp"
#include "services/dashboard/gateway/server.hpp"
#include "services/runtime/health.hpp"
#include "services/runtime/loop.hpp"
#include "services/runtime/options.hpp"
#include "services/runtime/version.hpp"
#include "services/store/open_store.hpp"

namespace tonus {
namespace {

constexpr char kProgram[] = "tonus-dashboard";

struct Options {
  runtime::CommonOptions common;
  std::string listen = "127.0.0.1:8765";
  std::string tokens;
  std::string certificate;
  std::string key;
  std::vector<std::string> origins;
  std::string pages;
  std::string store;
  std::string protocols;
  std::string reports;
  std::string exports;
};

void add_options(CLI::App& app, Options& o) {
  runtime::add_common_options(app, o.common);
  app.add_option("--listen", o.listen,
                 "ADDRESS:PORT; port 0: any that is free. Other addresses than this "
                 "machine's loopback need --tokens")
      ->capture_default_str();
  app.add_option("--tokens", o.tokens, "TOML file, view = [\"...\"] and operate = [\"...\"], mode 600");
  auto* certificate =
      app.add_option("--tls-certificate", o.certificate, "PEM file: certificate with its chain");
  auto* key = app.add_option("--tls-key", o.key, "PEM file: its private key");
  certificate->needs(key);
  key->needs(certificate);
  app.add_option("--allow-origin", o.origins, "other pages that may connect, e.g. https://app.foxglove.dev");
  app.add_option("--pages", o.pages, "folder of the built pages (default: beside the programs)");
  app.add_option("--store", o.store,
                 "archive, as tonus-archive's (default: archive.sqlite in the data folder)");
  app.add_option("--protocols", o.protocols, "folder of the protocols that pages offer");
  app.add_option("--reports", o.reports,
                 "folder of the reports that pages show (default: reports in the data "
                 "folder)");
  app.add_option("--exports", o.exports,
                 "folder of the exports that pages ask for (default: exports in the data folder)");
}

Result<dashboard::ServerOptions> server_options(const Options& o) {
  dashboard::ServerOptions server;
  auto listen = dashboard::parse_listen(o.listen);
  if (!listen) return listen.error();
  if (o.tokens.empty() && !dashboard::is_loopback_name(listen->address) && listen->address != "::1") {
    return fail(
        ErrorCode::kInvalidArgument,
        fmt::format("--listen: {} is not allowed without --tokens; expected an address of the loopback",
                    o.listen));
  }
  const auto data = runtime::data_folder(o.common);
  if (!data) return data.error();
  server.listen = *listen;
  server.certificate = o.certificate;
  server.key = o.key;
  server.folders.store = o.store.empty() ? store::default_store(*data).string() : o.store;
  server.folders.protocols =
      o.protocols.empty() ? installation().share / "protocols" : std::filesystem::path(o.protocols);
  server.folders.reports = o.reports.empty() ? *data / "reports" : std::filesystem::path(o.reports);
  server.folders.exports = o.exports.empty() ? *data / "exports" : std::filesystem::path(o.exports);
  server.folders.tonus = installation().programs / "tonus";
  server.info_json = nlohmann::json{{"program", kProgram},
                                    {"version", runtime::kVersion},
                                    {"rig", o.common.rig},
                                    {"needs_token", !o.tokens.empty()}}
                         .dump();
  return server;
}

Result<dashboard::Access> access_of(const Options& o) {
  dashboard::Tokens tokens;
  if (!o.tokens.empty()) {
    auto loaded = dashboard::load_tokens(o.tokens);
    if (!loaded) return loaded.error();
    tokens = std::move(*loaded);
    if (o.certificate.empty())
      spdlog::warn("tokens go over the network in clear: --tls-certificate and --tls-key protect them");
  }
  return dashboard::Access(std::move(tokens), o.origins);
}

std::optional<dashboard::Pages> pages_of(const Options& o) {
  auto pages = dashboard::Pages::load(o.pages.empty() ? installation().share / "pages"
                                                      : std::filesystem::path(o.pages));
  if (!pages) {
    spdlog::warn("no pages are served: {}", pages.error().message);
    return std::nullopt;
  }
  if (const auto added = pages->add(installation().share / "manual", "/manual"); !added)
    spdlog::info("no manual is served: {}", added.error().message);
  return std::move(*pages);
}

Result<void> run(const Options& options) {
  using namespace dashboard;
  const auto notifier = std::make_shared<bus::Notifier>();
  const StopSignal stop([notifier] { notifier->notify(); });
  const SystemClock clock;

  auto serving = server_options(options);
  if (!serving) return serving.error();
  auto access = access_of(options);
  if (!access) return access.error();
  DeskThread* desk = nullptr;
  Hub::Options hub_options;
  hub_options.rig = rig_id(options.common.rig);
  hub_options.session = to_hex(random_id());
  hub_options.metadata = {{"version", runtime::kVersion}, {"idl_hash", to_hex(runtime::idl_hash())}};
  Hub hub(offered_topics(), hub_options, clock,
          [&desk](OperatorRequest request) { desk->ask(std::move(request)); });
  auto server = Server::create(std::move(*serving), std::move(*access), pages_of(options), hub, clock);
  if (!server) return server.error();
  Inbox inbox([&server] { (*server)->wake(); });

  const auto bus = runtime::open_bus(options.common, kProgram);
  if (!bus) return bus.error();
  auto reader = BusReader::create(**bus, hub.topics(), inbox, clock, notifier);
  if (!reader) return reader.error();
  auto stop_bus = runtime::open_bus(options.common, std::string(kProgram) + " stop");
  if (!stop_bus) return stop_bus.error();
  auto made_desk = DeskThread::start(**bus, std::move(*stop_bus), inbox, clock);
  if (!made_desk) return made_desk.error();
  desk = made_desk->get();
  auto health = runtime::HealthReporter::create(**bus, clock, v1::ROLE_DASHBOARD, options.common, notifier);
  if (!health) return health.error();

  (*server)->start(inbox, [&](const Hub& now) {
    for (const auto& topic : now.topics()) (*reader)->want(topic.channel.id, now.is_wanted(topic.channel.id));
  });
  const std::string url = (*server)->url();
  std::printf("dashboard: %s\n", url.c_str());
  std::fflush(stdout);

  runtime::run_loop(*notifier, stop, [&] {
    auto due = (*reader)->step();
    if (!due) spdlog::error("{}", due.error().message);
    health->set_state(true, "serves " + url);
    health->set_load((*reader)->lag(), 0, (*reader)->malformed() + inbox.state_dropped());
    const auto next = health->publish_if_due();
    return due ? std::min(*due, next) : next;
  });
  (*server)->stop();  // its thread uses desk and reader
  return {};
}

}  // namespace
}  // namespace tonus

int main(int argc, char** argv) {
  using namespace tonus;
  runtime::begin_program();
  CLI::App app("Serves the session's pages to browsers, and its data to Foxglove and its like.", kProgram);
  Options options;
  add_options(app, options);
  runtime::set_example(app, "tonus-dashboard --listen 127.0.0.1:8765");
  if (const int code = runtime::parse_command_line(app, argc, argv); code >= 0) return code;
  runtime::start_log(kProgram, options.common);
  const auto outcome = run(options);
  return runtime::end_program(kProgram, outcome ? 0 : runtime::report(kProgram, outcome.error()));
}
