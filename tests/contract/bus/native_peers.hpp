#pragma once

#include <memory>
#include <optional>

#include "services/bus/bus.hpp"

/// Peers that know nothing of tonus::bus: the vendors' own writers and readers of the generated type in
/// probe.idl, one of each on topic "native/probe", reliable, transient-local, kept in full.
namespace tonus::bus::test {

inline constexpr const char* kNativeTopic = "native/probe";

/// The members of a Probe that the tests look at.
struct ProbeFacts {
  Key id{};
  std::uint64_t sequence_number = 0;
  std::string note;
  std::vector<double> values;
  std::uint8_t tail = 0;
  std::optional<Key> key_hash;  ///< As the vendor computed it, where it tells.
  bool operator==(const ProbeFacts&) const = default;
};

class NativePeer {
 public:
  virtual ~NativePeer() = default;
  [[nodiscard]] virtual bool write(const ProbeFacts& facts) = 0;
  [[nodiscard]] virtual std::vector<ProbeFacts> take() = 0;
};

[[nodiscard]] std::unique_ptr<NativePeer> open_native_fast(const BusOptions& options);
[[nodiscard]] std::unique_ptr<NativePeer> open_native_cyclone(const BusOptions& options);

/// Sends any bytes, good or not, under a topic of the bus.
class RawWriter {
 public:
  virtual ~RawWriter() = default;
  [[nodiscard]] virtual bool write(Payload bytes) = 0;
  [[nodiscard]] virtual int matched_readers() const = 0;
};

[[nodiscard]] std::unique_ptr<RawWriter> open_raw_fast(const BusOptions& options, const TopicSpec& topic);
[[nodiscard]] std::unique_ptr<RawWriter> open_raw_cyclone(const BusOptions& options, const TopicSpec& topic);

/// A native Cyclone DDS writer of the type in impostor.idl, which bears the Probe's name with other members.
class Impostor {
 public:
  virtual ~Impostor() = default;
  [[nodiscard]] virtual bool write(const Key& id, std::uint64_t number) = 0;
};

[[nodiscard]] std::unique_ptr<Impostor> open_impostor(const BusOptions& options, const TopicSpec& topic);

}  // namespace tonus::bus::test
