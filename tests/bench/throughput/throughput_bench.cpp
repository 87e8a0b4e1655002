// Samples a second from one process to another over the bus, one sample a message and in blocks, beside the
// same bytes through a TCP connection on the loopback.

#include <CLI/CLI.hpp>
#include <arpa/inet.h>
#include <chrono>
#include <cstdio>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>
#include <sys/socket.h>
#include <unistd.h>

#include "idl/topics.hpp"
#include "services/bus/typed.hpp"
#include "services/core/id.hpp"
#include "tests/bench/bench_bus.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kLimit{60};
constexpr bus::TopicSpec kBlocks{"bench/blocks", "tonus::v1::SampleBlock", topics::qos::kStream, 32768};

struct Asked {
  std::string dds = "fastdds";
  std::vector<int> blocks{1, 25};  // samples in each
  int samples = 50'000;            // of each size
  bool is_json = false;
  std::string take;  // of the program's own children: "bus" or "tcp"
  int domain = 0;
};

bus::Payload block_of(int samples) {
  v1::SampleBlock block;
  block.rig_id(id_of("bench"));
  block.samples().resize(static_cast<std::size_t>(samples));
  return bus::encode(block).value();
}

/// Takes until it is killed.
int take_from_bus(const Asked& asked) {
  const auto notifier = std::make_shared<bus::Notifier>();
  const auto bus = bus::create_bus(bench::bus_options(asked.dds, asked.domain, "throughput-reader"));
  if (!bus) return 1;
  const auto reader = (*bus)->create_reader(kBlocks, notifier);
  if (!reader) return 1;
  std::vector<bus::Sample> samples;
  while (true) {
    (void)notifier->wait_until(Clock::time_point::max());
    do {
      samples.clear();
    } while ((*reader)->take(samples) > 0);
  }
}

/// Reads one connection to its end and answers by one byte.
int take_from_tcp() {
  const int listening = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof own;
  if (::bind(listening, reinterpret_cast<sockaddr*>(&own), size) != 0 || ::listen(listening, 1) != 0)
    return 1;
  ::getsockname(listening, reinterpret_cast<sockaddr*>(&own), &size);
  std::printf("%u\n", static_cast<unsigned>(ntohs(own.sin_port)));
  std::fflush(stdout);
  while (true) {
    const int link = ::accept(listening, nullptr, nullptr);
    if (link < 0) return 1;
    std::vector<char> buffer(65536);
    while (::read(link, buffer.data(), buffer.size()) > 0) {
    }
    if (::write(link, "x", 1) != 1) return 1;
    ::close(link);
  }
}

/// Seconds until `count` payloads were written and the reader has acknowledged all.
Result<double> through_bus(bus::Writer& writer, const bus::Payload& payload, int count) {
  const auto begin = Clock::now();
  for (int i = 0; i < count;) {
    if (const auto written = writer.write(payload)) {
      ++i;
    } else if (written.error().code != ErrorCode::kTimeout || Clock::now() > begin + kLimit) {
      return written.error();
    }
  }
  if (!writer.wait_acknowledged(kLimit)) return fail(ErrorCode::kTimeout, "not everything was acknowledged");
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Seconds until the other end has read the same.
Result<double> through_tcp(int port, const bus::Payload& payload, int count) {
  const int link = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int is_immediate = 1;
  ::setsockopt(link, IPPROTO_TCP, TCP_NODELAY, &is_immediate, sizeof is_immediate);
  if (::connect(link, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0)
    return fail(ErrorCode::kUnavailable, "no connection on the loopback");
  const auto begin = Clock::now();
  for (int i = 0; i < count; ++i) {
    for (std::size_t sent = 0; sent < payload.size();) {
      const auto more = ::send(link, payload.data() + sent, payload.size() - sent, MSG_NOSIGNAL);
      if (more <= 0) return fail(ErrorCode::kIo, "the connection on the loopback broke");
      sent += static_cast<std::size_t>(more);
    }
  }
  ::shutdown(link, SHUT_WR);
  char answer = 0;
  const bool is_read = ::read(link, &answer, 1) == 1;
  const double taken = std::chrono::duration<double>(Clock::now() - begin).count();
  ::close(link);
  if (!is_read) return fail(ErrorCode::kIo, "the connection on the loopback broke");
  return taken;
}

Result<nlohmann::json> measure(const Asked& asked) {
  const testing::TemporaryFolder folder;
  testing::Process reader("/proc/self/exe",
                          {"--take", "bus", "--dds", asked.dds, "--domain", std::to_string(asked.domain)},
                          folder / "bus");
  testing::Process tcp("/proc/self/exe", {"--take", "tcp"}, folder / "tcp");
  if (!tcp.wait_for_output("\n", std::chrono::seconds(10)))
    return fail(ErrorCode::kUnavailable, "the reader on the loopback did not start");
  const int port = std::stoi(tcp.output());
  TONUS_TRY_ASSIGN(const auto bus,
                   bus::create_bus(bench::bus_options(asked.dds, asked.domain, "throughput-writer")));
  TONUS_TRY_ASSIGN(const auto writer, bus->create_writer(kBlocks));
  const auto limit = Clock::now() + kLimit;
  while (writer->status().matched_readers == 0) {
    if (Clock::now() > limit) return fail(ErrorCode::kTimeout, "the reader did not come");
    usleep(1000);
  }
  nlohmann::json rows = nlohmann::json::array();
  for (const int samples : asked.blocks) {
    const auto payload = block_of(samples);
    const int count = std::max(1, asked.samples / samples);
    TONUS_TRY_ASSIGN(const double seconds, through_bus(*writer, payload, count));
    TONUS_TRY_ASSIGN(const double tcp_seconds, through_tcp(port, payload, count));
    rows.push_back({{"block_samples", samples},
                    {"block_bytes", payload.size()},
                    {"samples_per_s", static_cast<double>(count) * samples / seconds},
                    {"tcp_samples_per_s", static_cast<double>(count) * samples / tcp_seconds}});
  }
  return nlohmann::json{{"dds", asked.dds}, {"rows", rows}};
}

}  // namespace
}  // namespace tonus::bench

int main(int argc, char** argv) {
  using namespace tonus;
  CLI::App app("Samples a second over the bus, beside TCP.", "throughput_bench");
  bench::Asked asked;
  app.add_option("--dds", asked.dds, "fastdds or cyclonedds")
      ->check(CLI::IsMember({"fastdds", "cyclonedds"}))
      ->capture_default_str();
  app.add_option("--blocks", asked.blocks, "samples in a message, with commas between")
      ->delimiter(',')
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  app.add_option("--samples", asked.samples, "sent of each size")
      ->check(CLI::Range(100, 100'000'000))
      ->capture_default_str();
  app.add_flag("--json", asked.is_json, "one object instead of the lines");
  app.add_option("--take", asked.take)->group("");
  app.add_option("--domain", asked.domain)->group("");
  CLI11_PARSE(app, argc, argv);
  if (asked.take == "bus") return bench::take_from_bus(asked);
  if (asked.take == "tcp") return bench::take_from_tcp();
  asked.domain = testing::own_domain();
  const auto measured = bench::measure(asked);
  if (!measured) {
    fmt::print(stderr, "throughput_bench: {}\n", measured.error().message);
    return 1;
  }
  if (asked.is_json) {
    fmt::print("{}\n", measured->dump());
    return 0;
  }
  for (const auto& row : measured->at("rows"))
    fmt::print("{}, {} samples a message ({} bytes): {:.0f} samples/s, TCP {:.0f}\n", asked.dds,
               row["block_samples"].get<int>(), row["block_bytes"].get<int>(),
               row["samples_per_s"].get<double>(), row["tcp_samples_per_s"].get<double>());
  return 0;
}
