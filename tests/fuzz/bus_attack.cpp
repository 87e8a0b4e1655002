#include "tests/fuzz/bus_attack.hpp"

#include <array>
#include <exception>
#include <fstream>
#include <map>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "idl/topics.hpp"
#include "services/runtime/options.hpp"
#include "tests/fault/rig/live_system.hpp"
#include "tests/fuzz/packet_capture.hpp"

namespace tonus::fuzz {
namespace {

constexpr double kMostGrowth_MB = 64.0;
constexpr std::array kPrograms{"tonus-rig-agent", "tonus-scheduler", "tonus-identification", "tonus-archive",
                               "tonus-dashboard"};
constexpr std::uint64_t kInputsBetweenLooks = 500;
constexpr std::chrono::seconds kPatience{120};

double resident_MB(pid_t process) {
  std::ifstream in("/proc/" + std::to_string(process) + "/statm");
  std::uint64_t size = 0;
  std::uint64_t resident = 0;
  in >> size >> resident;
  return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// The programs of the system as they were at the beginning.
class Victims {
 public:
  explicit Victims(const testing::LiveSystem& system) : system_(system) {
    for (const char* name : kPrograms) {
      if (const pid_t process = system.service(name); process != 0)
        programs_[name] = {process, resident_MB(process)};
    }
  }

  /// None is missing from the attack.
  [[nodiscard]] Result<void> look_for_all() const {
    for (const char* name : kPrograms)
      if (!programs_.contains(name)) return fail(ErrorCode::kNotFound, fmt::format("{} does not run", name));
    return {};
  }

  /// All are the same processes, and none has grown beyond what is allowed.
  Result<void> look(BusAttackReport& report) const {
    for (const auto& [name, before] : programs_) {
      if (system_.service(name) != before.process)
        return fail(ErrorCode::kInternal, name + " has ended\n" + system_.everything_printed());
      const double growth = resident_MB(before.process) - before.resident_MB;
      if (growth > report.growth_MB) {
        report.growth_MB = growth;
        report.largest = name;
      }
      if (growth > kMostGrowth_MB)
        return fail(ErrorCode::kInternal, fmt::format("{} has grown by {:.0f} MB", name, growth));
    }
    return {};
  }

 private:
  struct Program {
    pid_t process = 0;
    double resident_MB = 0.0;
  };
  const testing::LiveSystem& system_;
  std::map<std::string, Program> programs_;
};

void show(const BusAttack& attack, const char* what, std::uint64_t done, std::uint64_t all) {
  if (attack.shows_progress) fmt::print(stderr, "\r{}: {} of {} ", what, done, all);
}

/// A header's field of a submessage: an id, flags or a length that others have not.
void set_submessage(Damage& damage, Bytes& bytes) {
  if (bytes.size() < 24) return;
  const std::uint64_t at = damage.draw(0, 1) == 0 ? 20 : damage.draw(20, bytes.size() - 4);
  bytes[at + damage.draw(0, 3)] = static_cast<std::byte>(damage.draw(0, 255));
}

Result<void> send_packets(const BusAttack& attack, testing::LiveSystem& system, const Victims& victims,
                          BusAttackReport& report) {
  TONUS_TRY_ASSIGN(const std::vector<Bytes> captured, capture_rtps(std::chrono::seconds(4), 20'000));
  const std::vector<std::uint16_t> ports = udp_ports();
  if (captured.empty() || ports.empty()) return fail(ErrorCode::kInternal, "nothing is said on the bus");
  report.captured = captured.size();
  report.ports = ports.size();
  const PacketGun gun;
  for (; report.packets < attack.packets; ++report.packets) {
    Damage damage(attack.seed + report.packets);
    Bytes bytes = captured[damage.draw(0, captured.size() - 1)];
    for (auto times = damage.draw(0, 2); times > 0; --times) set_submessage(damage, bytes);
    if (damage.draw(0, 3) != 0) damage.apply(bytes);
    gun.send(bytes, ports[damage.draw(0, ports.size() - 1)]);
    if (report.packets % kInputsBetweenLooks != 0) continue;
    show(attack, "packets", report.packets, attack.packets);
    (void)system.listen_until([] { return true; }, kPatience);
    TONUS_TRY(victims.look(report));
  }
  return {};
}

/// A message of each topic as it is made by default, and what was heard of it.
struct Contents {
  bus::TopicSpec topic;
  std::unique_ptr<bus::Writer> writer;
  std::unique_ptr<bus::Reader> reader;
  std::vector<Bytes> samples;

  void hear() {
    std::vector<bus::Sample> heard;
    (void)reader->take(heard);
    for (const bus::Sample& sample : heard) {
      if (samples.size() < 50) samples.push_back(*sample.payload);
    }
  }
};

Result<std::vector<Contents>> contents_of_all(bus::Bus& bus) {
  std::vector<Contents> all;
  Result<void> outcome;
  const auto add = [&]<typename T>(const topics::Topic<T>& topic) {
    auto writer = bus.create_writer(topic.spec);
    auto reader = bus.create_reader(topic.spec, nullptr);
    auto sample = bus::encode(T{});
    if (!writer || !reader || !sample) {
      outcome = fail(ErrorCode::kInternal, std::string(topic.spec.name) + " cannot be opened");
      return;
    }
    all.push_back({topic.spec, std::move(*writer), std::move(*reader), {std::move(*sample)}});
  };
  std::apply([&](const auto&... topic) { (add(topic), ...); }, topics::kTyped);
  if (!outcome) return outcome.error();
  return all;
}

Result<void> send_messages(const BusAttack& attack, testing::LiveSystem& system, const Victims& victims,
                           BusAttackReport& report) {
  constexpr std::size_t kKeyEnd = 20;
  runtime::CommonOptions common;
  common.domain = testing::own_domain();
  common.dds = attack.dds;
  TONUS_TRY_ASSIGN(const auto bus, runtime::open_bus(common, "bus-fuzz"));
  TONUS_TRY_ASSIGN(std::vector<Contents> topics, contents_of_all(*bus));
  for (std::uint64_t i = 0; i < attack.messages; ++i) {
    Damage damage(attack.seed + i);
    Contents& contents = topics[i % topics.size()];
    Bytes bytes = contents.samples[damage.draw(0, contents.samples.size() - 1)];
    Bytes members(bytes.begin() + kKeyEnd, bytes.end());
    damage.apply(members);
    bytes.resize(kKeyEnd);
    bytes.insert(bytes.end(), members.begin(), members.end());
    ++(contents.writer->write(bytes) ? report.messages : report.refused);
    if (i % kInputsBetweenLooks != 0) continue;
    for (Contents& one : topics) one.hear();
    show(attack, "messages", i, attack.messages);
    (void)system.listen_until([] { return true; }, kPatience);
    TONUS_TRY(victims.look(report));
  }
  return {};
}

Result<BusAttackReport> run(const BusAttack& attack) {
  testing::LiveSystem system(testing::LiveSystem::Unattended::kYes, attack.dds, 3.0, {"--dashboard"});
  system.start_session(40);
  if (!system.wait_for_mid_trial(40, kPatience))
    return fail(ErrorCode::kTimeout, "the rig runs no trial\n" + system.everything_printed());
  BusAttackReport report;
  const Victims victims(system);
  TONUS_TRY(victims.look_for_all());
  TONUS_TRY(send_packets(attack, system, victims, report));
  TONUS_TRY(send_messages(attack, system, victims, report));
  // What was sent last has been handled when the rig has spoken for a while.
  (void)system.listen_until([] { return false; }, std::chrono::seconds(2));
  TONUS_TRY(victims.look(report));
  return report;
}

}  // namespace

Result<BusAttackReport> attack_bus(const BusAttack& attack) {
  try {
    return run(attack);
  } catch (const std::exception& error) {
    return Error{ErrorCode::kInternal, error.what()};
  }
}

std::string text_of(const BusAttackReport& report) {
  return fmt::format(
      "{} packets, mutated from {} captured ones, to {} ports; {} messages of {} topics, {} more refused on "
      "sending; no program ended; memory grew by at most {:.1f} MB{}\n",
      report.packets, report.captured, report.ports, report.messages, topics::kAll.size(), report.refused,
      report.growth_MB, report.largest.empty() ? "" : " (" + report.largest + ")");
}

}  // namespace tonus::fuzz
