#include "services/bus/partitions.hpp"

#include <algorithm>

#include "tests/contract/bus/contract_fixture.hpp"

namespace tonus::bus::test {
namespace {

/// One participant in the places of two rigs and in both at once, and one program of each rig.
class BusPartitions : public testing::TestWithParam<Pairing> {
 protected:
  void SetUp() override {
    auto buses = create_buses(bus_options(GetParam().writer, nullptr, "serving"),
                              {{"left"}, {"right"}, {"left", "right"}});
    ASSERT_TRUE(buses) << buses.error().message;
    serving_ = std::move(*buses);
    for (const char* rig : {"left", "right"}) {
      BusOptions options = bus_options(GetParam().reader, nullptr, rig);
      options.partition = rig;
      rigs_.push_back(open_bus(options));
      ASSERT_TRUE(rigs_.back());
    }
  }

  std::vector<std::unique_ptr<Bus>> serving_;
  std::vector<std::unique_ptr<Bus>> rigs_;
  std::shared_ptr<Notifier> notifier_ = std::make_shared<Notifier>();
};
INSTANTIATE_TEST_SUITE_P(Pairs, BusPartitions, kNetworkPairings, pairing_name);

TEST_P(BusPartitions, AWriterOfOnePlaceIsHeardByThatRigAlone) {
  const TopicSpec spec = topic("contract/answers", keep_all(8));
  auto to_left = serving_[0]->create_writer(spec);
  auto to_right = serving_[1]->create_writer(spec);
  auto left = rigs_[0]->create_reader(spec, notifier_);
  auto right = rigs_[1]->create_reader(spec, notifier_);
  ASSERT_TRUE(to_left && to_right && left && right);
  ASSERT_TRUE(are_matched(**to_left, **left));
  ASSERT_TRUE(are_matched(**to_right, **right));

  ASSERT_TRUE((*to_left)->write(payload(1, 10)));
  ASSERT_TRUE((*to_right)->write(payload(1, 20)));

  EXPECT_EQ(numbers_of(receive(**left, *notifier_, 1)), (std::vector<std::uint64_t>{10}));
  EXPECT_EQ(numbers_of(receive(**right, *notifier_, 1)), (std::vector<std::uint64_t>{20}));
}

TEST_P(BusPartitions, AReaderOfSeveralPartitionsHearsEachRig) {
  const TopicSpec spec = topic("contract/samples", keep_all(8));
  auto both = serving_[2]->create_reader(spec, notifier_);
  auto left = rigs_[0]->create_writer(spec);
  auto right = rigs_[1]->create_writer(spec);
  ASSERT_TRUE(both && left && right);
  ASSERT_TRUE(tonus::test::eventually([&] {
    return (*both)->status().matched_writers == 2 && (*left)->status().matched_readers == 1 &&
           (*right)->status().matched_readers == 1;
  }));

  ASSERT_TRUE((*left)->write(payload(1, 10)));
  ASSERT_TRUE((*right)->write(payload(2, 20)));

  auto heard = numbers_of(receive(**both, *notifier_, 2));
  std::sort(heard.begin(), heard.end());
  EXPECT_EQ(heard, (std::vector<std::uint64_t>{10, 20}));
}

TEST_P(BusPartitions, GoesOnWhileAWriterOfItLives) {
  const TopicSpec spec = topic("contract/last", keep_all(8));
  auto writer = serving_[1]->create_writer(spec);
  auto reader = rigs_[1]->create_reader(spec, notifier_);
  ASSERT_TRUE(writer && reader);
  serving_.clear();
  ASSERT_TRUE(are_matched(**writer, **reader));
  ASSERT_TRUE((*writer)->write(payload(1, 30)));
  EXPECT_EQ(numbers_of(receive(**reader, *notifier_, 1)), (std::vector<std::uint64_t>{30}));
}

TEST(BusPartitionsCheck, RefusesAPlaceWithoutPartitionAndAPattern) {
  EXPECT_EQ(create_buses(bus_options(Vendor::kFastDds), {{}}).error().message,
            "partitions: none is not allowed; expected at least one");
  EXPECT_EQ(create_buses(bus_options(Vendor::kFastDds), {{"left"}, {"*"}}).error().message,
            "partition: '*' is not allowed; expected letters, digits, '-', '_' and '.'");
}

}  // namespace
}  // namespace tonus::bus::test
