#pragma once

#include <gtest/gtest.h>
#include <memory>
#include <string>
#include <vector>

#include "services/bus/memory/memory_fabric.hpp"
#include "tests/contract/bus/test_topics.hpp"
#include "tests/support/bus/child_process.hpp"
#include "tests/support/bus/eventually.hpp"

namespace tonus::bus::test {

/// Which vendor writes and which reads.
struct Pairing {
  Vendor writer;
  Vendor reader;
};

inline std::string pairing_name(const testing::TestParamInfo<Pairing>& info) {
  return std::string(vendor_name(info.param.writer)) + "_to_" + std::string(vendor_name(info.param.reader));
}

inline std::string carrier_name(const testing::TestParamInfo<Vendor>& info) {
  return std::string(vendor_name(info.param));
}

inline const auto kAllPairings = testing::Values(
    Pairing{Vendor::kMemory, Vendor::kMemory}, Pairing{Vendor::kFastDds, Vendor::kFastDds},
    Pairing{Vendor::kCycloneDds, Vendor::kCycloneDds}, Pairing{Vendor::kFastDds, Vendor::kCycloneDds},
    Pairing{Vendor::kCycloneDds, Vendor::kFastDds});

inline const auto kNetworkPairings = testing::Values(
    Pairing{Vendor::kFastDds, Vendor::kFastDds}, Pairing{Vendor::kCycloneDds, Vendor::kCycloneDds},
    Pairing{Vendor::kFastDds, Vendor::kCycloneDds}, Pairing{Vendor::kCycloneDds, Vendor::kFastDds});

/// The domain of this test process: alone in its network any will do, else one that others hardly use.
[[nodiscard]] int test_domain();

[[nodiscard]] BusOptions bus_options(Vendor vendor, const std::shared_ptr<MemoryFabric>& fabric = nullptr,
                                     const std::string& name = "contract");
[[nodiscard]] std::unique_ptr<Bus> open_bus(const BusOptions& options);

/// Waits until both know each other.
[[nodiscard]] bool are_matched(const Writer& writer, const Reader& reader);

/// Takes until `count` samples have come, woken by the notifier as a service is.
[[nodiscard]] std::vector<Sample> receive(Reader& reader, Notifier& notifier, std::size_t count);

[[nodiscard]] std::vector<std::uint64_t> numbers_of(const std::vector<Sample>& samples);

/// Two buses in one domain, one for each side of a pairing.
class BusContract : public testing::TestWithParam<Pairing> {
 protected:
  void SetUp() override;
  [[nodiscard]] std::unique_ptr<Writer> make_writer(const TopicSpec& spec) const;
  [[nodiscard]] std::unique_ptr<Reader> make_reader(const TopicSpec& spec) const;

  std::shared_ptr<MemoryFabric> fabric_ = std::make_shared<MemoryFabric>();
  std::unique_ptr<Bus> writing_bus_;
  std::unique_ptr<Bus> reading_bus_;
  std::shared_ptr<Notifier> notifier_ = std::make_shared<Notifier>();
};

}  // namespace tonus::bus::test
