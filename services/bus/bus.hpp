#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "services/bus/notifier.hpp"
#include "services/core/result.hpp"

/// Publish and subscribe of serialised messages, by one of three carriers chosen at run time.
///
/// The bus moves bytes: a payload is one complete CDR message as RTPS carries it, that is the 4-byte
/// encapsulation header 00 01 xx xx (plain CDR, XCDR1, little endian) and the members. Every type of the
/// contract is @final and its first member is its only key, `@key octet xxx_id[16]`; so bytes 4 to 19 of any
/// payload are its key, and no carrier has to know a type. Typed access is a thin layer above: typed.hpp.
namespace tonus::bus {

/// Who carries the messages. Processes on Fast DDS and on Cyclone DDS understand each other.
enum class Vendor : std::uint8_t {
  kMemory,      ///< Within one process, for tests.
  kFastDds,     ///< eProsima Fast DDS.
  kCycloneDds,  ///< Eclipse Cyclone DDS.
};

/// "fastdds", "cyclonedds" or "memory".
[[nodiscard]] Result<Vendor> parse_vendor(std::string_view text);
[[nodiscard]] std::string_view vendor_name(Vendor vendor);

enum class Durability : std::uint8_t {
  kVolatile,        ///< A reader gets what is written while it is matched.
  kTransientLocal,  ///< A late reader also gets the history of the writers that still live.
};

enum class History : std::uint8_t {
  kKeepLast,  ///< The last `depth` samples of each key; older ones give way, also those not yet delivered.
  kKeepAll,   ///< Nothing gives way: a writer whose unacknowledged samples fill the history refuses the next.
};

/// What a topic promises. Both ends of a topic use the same.
struct Qos {
  bool reliable = true;
  Durability durability = Durability::kVolatile;
  History history = History::kKeepLast;
  /// kKeepLast: samples kept per key. kKeepAll: at most so many samples a writer holds unacknowledged in
  /// total, and so many a reader holds untaken before it stops acknowledging (in total; Fast DDS counts the
  /// reader's per key). With kTransientLocal a late reader gets up to so many of each key.
  int depth = 1;
  std::chrono::milliseconds deadline{0};  ///< Each key is written at least this often; 0: no deadline.
  std::chrono::milliseconds liveliness_lease{0};  ///< A writer silent for this long counts as dead; 0: never.
  std::chrono::milliseconds max_blocking{100};    ///< Longest time that write() waits for room.
};

struct TopicSpec {
  std::string_view name;       ///< Must outlive no call: carriers copy it.
  std::string_view type_name;  ///< As DDS names it, "tonus::v1::Name".
  Qos qos;
  std::size_t max_payload_bytes = 65536;  ///< With the header; larger ones are refused on both sides.
};

using Payload = std::vector<std::byte>;
using Key = std::array<std::uint8_t, 16>;

struct Sample {
  std::shared_ptr<const Payload>
      payload;  ///< Checked: header, key and length are good. Zero-padded to 4 bytes.
  Key key{};
  std::int64_t source_timestamp_ns = 0;  ///< When it was written: the writer's system clock, ns of UTC.
  std::int64_t received_ns = 0;          ///< When it reached this process: std::chrono::steady_clock, ns.
};

struct WriterStatus {
  int matched_readers = 0;
  std::uint64_t written = 0;          ///< Samples that write() accepted.
  std::uint64_t refused = 0;          ///< Samples that write() did not take, whatever the reason.
  std::uint64_t deadline_missed = 0;  ///< Times that a key was not written within the deadline.
};

struct ReaderStatus {
  int matched_writers = 0;
  int alive_writers = 0;        ///< Matched writers that kept their liveliness.
  std::uint64_t received = 0;   ///< Good samples that take() handed out.
  std::uint64_t malformed = 0;  ///< Samples refused: too short, too long, or of a wrong encapsulation.
  std::uint64_t lost = 0;       ///< Samples that the carrier reports as lost.
  std::uint64_t liveliness_lost_events =
      0;                              ///< Times that a matched writer stopped being alive without goodbye.
  std::uint64_t deadline_missed = 0;  ///< Times that a key was not received within the deadline.
};

/// Publishes to one topic. write() may be called from any thread, one at a time takes effect; never from a
/// realtime thread, as it allocates and may wait.
class Writer {
 public:
  virtual ~Writer() = default;

  /// Hands one payload to the carrier, which copies it.
  /// kTimeout: the history of a kKeepAll topic stayed full for max_blocking, or a reader that has just been
  /// matched has not answered in that time; the sample was not sent and may be tried again. kInvalidArgument:
  /// too short for header and key, not XCDR1 little endian, or over max_payload_bytes.
  [[nodiscard]] virtual Result<void> write(std::span<const std::byte> payload) = 0;

  [[nodiscard]] virtual WriterStatus status() const = 0;

  /// True as soon as every matched reader has received everything written so far; false after `limit`.
  virtual bool wait_acknowledged(std::chrono::milliseconds limit) = 0;
};

/// Subscribes to one topic. All methods from any thread; samples of one writer come in the order of their
/// writing.
class Reader {
 public:
  virtual ~Reader() = default;

  /// Appends up to `max` samples that have arrived to `out`, and returns how many. Never waits.
  virtual std::size_t take(std::vector<Sample>& out, std::size_t max = 256) = 0;

  [[nodiscard]] virtual ReaderStatus status() const = 0;
};

/// One participant of one domain. Its writers and readers may outlive it.
class Bus {
 public:
  virtual ~Bus() = default;

  [[nodiscard]] virtual Result<std::unique_ptr<Writer>> create_writer(const TopicSpec& topic) = 0;

  /// The notifier is signalled when data arrive and when the status changes; it may be shared by many
  /// readers, and may be null.
  [[nodiscard]] virtual Result<std::unique_ptr<Reader>> create_reader(const TopicSpec& topic,
                                                                      std::shared_ptr<Notifier> notifier) = 0;
};

/// Where a discovery server of Fast DDS listens.
struct DiscoveryServerAddress {
  std::string address;  ///< IPv4, dotted.
  std::uint16_t port = 11811;
};

/// Where packets may go. The default never leaves the machine: loopback, unicast only. A laboratory's network
/// names its interface by address and its hosts as peers; there is no multicast in either.
struct NetworkProfile {
  std::string interface_address = "127.0.0.1";  ///< IPv4, dotted.
  std::vector<std::string> peers = {
      "127.0.0.1"};  ///< IPv4, dotted; every host that takes part, this one too.
  /// kFastDds only: where there are any, participants are found by asking these, and `peers` is not used. All
  /// processes name the same servers in the same order.
  std::vector<DiscoveryServerAddress> discovery_servers;
};

/// What DDS Security needs of one identity: PEM files, and documents signed by the authority. All
/// participants of a secured domain are of one vendor.
struct SecurityFiles {
  std::filesystem::path authority;  ///< Certificate that signed all others, and governance and permissions.
  std::filesystem::path revoked;    ///< Its list of revoked certificates.
  std::filesystem::path certificate;
  std::filesystem::path key;
  std::filesystem::path governance;   ///< What the domain protects.
  std::filesystem::path permissions;  ///< What this identity may write and read.
};

class MemoryFabric;

struct BusOptions {
  Vendor vendor = Vendor::kFastDds;
  int domain = 0;  ///< 0 to 232.
  NetworkProfile network;
  std::string participant_name = "tonus";
  /// Writers and readers of one partition hear each other alone; several rigs share a domain that way. Empty:
  /// DDS's default partition. kMemory has no partitions.
  std::string partition;
  std::optional<SecurityFiles>
      security;  ///< None: messages are neither encrypted nor checked. Not for kMemory.
  /// How long a participant that fell silent (killed, cut off) keeps its place with its peers. A reliable
  /// kKeepAll writer waits for a dead reader this long; a reader that is stopped for longer has to be found
  /// anew.
  std::chrono::milliseconds participant_lease{3000};
  std::shared_ptr<MemoryFabric> fabric;  ///< kMemory only: what the Bus objects of one process share.
};

/// Joins the domain. kInvalidArgument names the option, its value and what is allowed; kUnavailable when the
/// carrier cannot open its sockets.
[[nodiscard]] Result<std::unique_ptr<Bus>> create_bus(const BusOptions& options);

/// The IPv4 address, dotted, of an interface of this machine that is named by itself ("eth0") or by its
/// address. kUnavailable: there is none.
[[nodiscard]] Result<std::string> own_address(const std::string& interface);

}  // namespace tonus::bus
