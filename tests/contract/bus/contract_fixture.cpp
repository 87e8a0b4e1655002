#include "tests/contract/bus/contract_fixture.hpp"

#include <cstdio>
#include <unistd.h>

#include "tests/support/bus/private_network.hpp"

namespace tonus::bus::test {

int test_domain() {
  return tonus::test::is_in_private_network() ? 7 : 100 + static_cast<int>(getpid() % 100);
}

BusOptions bus_options(Vendor vendor, const std::shared_ptr<MemoryFabric>& fabric, const std::string& name) {
  BusOptions options;
  options.vendor = vendor;
  options.domain = test_domain();
  options.participant_name = name;
  options.fabric = fabric;
  return options;
}

std::unique_ptr<Bus> open_bus(const BusOptions& options) {
  auto bus = create_bus(options);
  EXPECT_TRUE(bus) << bus.error().message;
  return bus ? std::move(*bus) : nullptr;
}

bool are_matched(const Writer& writer, const Reader& reader) {
  return tonus::test::eventually(
      [&] { return writer.status().matched_readers == 1 && reader.status().matched_writers == 1; });
}

std::vector<Sample> receive(Reader& reader, Notifier& notifier, std::size_t count) {
  std::vector<Sample> samples;
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds{20};
  while (samples.size() < count) {
    reader.take(samples);
    if (samples.size() >= count) break;
    if (!notifier.wait_until(deadline)) break;
  }
  return samples;
}

std::vector<std::uint64_t> numbers_of(const std::vector<Sample>& samples) {
  std::vector<std::uint64_t> numbers;
  numbers.reserve(samples.size());
  for (const Sample& sample : samples) numbers.push_back(number_in(*sample.payload));
  return numbers;
}

void BusContract::SetUp() {
  writing_bus_ = open_bus(bus_options(GetParam().writer, fabric_, "writing"));
  reading_bus_ = open_bus(bus_options(GetParam().reader, fabric_, "reading"));
  ASSERT_TRUE(writing_bus_ && reading_bus_);
}

std::unique_ptr<Writer> BusContract::make_writer(const TopicSpec& spec) const {
  auto writer = writing_bus_->create_writer(spec);
  EXPECT_TRUE(writer) << writer.error().message;
  return writer ? std::move(*writer) : nullptr;
}

std::unique_ptr<Reader> BusContract::make_reader(const TopicSpec& spec) const {
  auto reader = reading_bus_->create_reader(spec, notifier_);
  EXPECT_TRUE(reader) << reader.error().message;
  return reader ? std::move(*reader) : nullptr;
}

}  // namespace tonus::bus::test

// Before any thread: each test process has a network to itself where the system permits that.
int main(int count, char** arguments) {
  testing::InitGoogleTest(&count, arguments);
  if (!testing::GTEST_FLAG(list_tests)) {
    if (auto entered = tonus::test::enter_private_network(); !entered) {
      std::printf("on this machine's own loopback: %s\n", entered.error().message.c_str());
    }
  }
  return RUN_ALL_TESTS();
}
