#include "services/dashboard/gateway/connection_table.hpp"

#include <gtest/gtest.h>
#include <vector>

namespace tonus::dashboard {
namespace {

/// A table whose connections note their end.
class Table {
 public:
  explicit Table(const ConnectionTable::Limits& limits) : table(limits) {}

  std::optional<ConnectionTable::Number> arrive(const std::string& address) {
    const int mine = next_++;
    const auto arrival = table.arrive(address, [this, mine] { ended.push_back(mine); });
    if (arrival.gives_way) arrival.gives_way();
    return arrival.number;
  }
  bool arrive_as(const std::string& address, Standing standing) {
    const auto number = arrive(address);
    return number && table.set_standing(*number, standing);
  }

  ConnectionTable table;
  std::vector<int> ended;  ///< In the order of arrival, from 0.

 private:
  int next_ = 0;
};

TEST(ConnectionTable, TheOldestUnprovenConnectionOfTheFullestAddressGivesWay) {
  Table table({.all = 4, .reserve = 1, .per_address = 4});
  for (const char* address : {"a", "b", "b", "b"}) EXPECT_TRUE(table.arrive(address));
  EXPECT_TRUE(table.arrive("c"));
  EXPECT_EQ(table.ended, std::vector<int>{1});
  EXPECT_EQ(table.table.size(), 4U);
}

TEST(ConnectionTable, AnAddressWithTooManyMakesRoomItself) {
  Table table({.all = 100, .reserve = 1, .per_address = 2});
  for (const char* address : {"a", "b", "b", "b", "b"}) EXPECT_TRUE(table.arrive(address));
  EXPECT_EQ(table.ended, (std::vector<int>{1, 2}));
}

TEST(ConnectionTable, ViewersLeaveTheReserveToOperators) {
  Table table({.all = 6, .reserve = 2, .per_address = 6});
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(table.arrive_as("a", Standing::kViewer));
  EXPECT_FALSE(table.arrive_as("b", Standing::kViewer));
  EXPECT_TRUE(table.arrive_as("a", Standing::kOperator));
  EXPECT_TRUE(table.arrive_as("c", Standing::kOperator));
  EXPECT_EQ(table.table.count(Standing::kOperator), 2U);
  EXPECT_EQ(table.ended, std::vector<int>{4}) << "the viewer that was refused";
}

TEST(ConnectionTable, ViewersOfOneAddressAreLimitedAndOperatorsBehindItAreNot) {
  Table table({.all = 100, .reserve = 2, .per_address = 3});
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(table.arrive_as("a", Standing::kViewer));
  EXPECT_FALSE(table.arrive_as("a", Standing::kViewer));
  EXPECT_TRUE(table.arrive_as("b", Standing::kViewer));
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(table.arrive_as("a", Standing::kOperator));
}

TEST(ConnectionTable, ProvenConnectionsNeverGiveWay) {
  Table table({.all = 3, .reserve = 1, .per_address = 3});
  EXPECT_TRUE(table.arrive_as("a", Standing::kViewer));
  EXPECT_TRUE(table.arrive_as("a", Standing::kOperator));
  EXPECT_TRUE(table.arrive_as("a", Standing::kOperator));
  EXPECT_FALSE(table.arrive("b"));
  EXPECT_TRUE(table.ended.empty());
}

TEST(ConnectionTable, WhoHasGivenWayIsKnownNoMore) {
  Table table({.all = 2, .reserve = 1, .per_address = 1});
  const auto first = table.arrive("a");
  const auto second = table.arrive("a");
  ASSERT_TRUE(first && second);
  EXPECT_FALSE(table.table.set_standing(*first, Standing::kOperator));
  table.table.leave(*first);
  EXPECT_TRUE(table.table.set_standing(*second, Standing::kOperator));
  table.table.leave(*second);
  EXPECT_EQ(table.table.size(), 0U);
}

TEST(ConnectionTable, OneMachinesIpv6AddressesCountAsOne) {
  EXPECT_EQ(counted_address("10.0.0.5"), "10.0.0.5");
  EXPECT_EQ(counted_address("::ffff:10.0.0.5"), "10.0.0.5");
  EXPECT_EQ(counted_address("2001:db8:1:2:3:4:5:6"), "2001:db8:1:2::");
  EXPECT_EQ(counted_address("2001:db8:1:2:ffff::"), "2001:db8:1:2::");
}

}  // namespace
}  // namespace tonus::dashboard
