#pragma once

#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <string>
#include <vector>

#include "services/store/store.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/store/made_up.hpp"

namespace tonus::store::testing {

/// A kind of store, and how an empty one is made; `folder` is the test's own. An error of kNotFound skips the
/// test: what the store needs is not installed.
struct StoreMaker {
  std::string name;
  std::function<Result<std::unique_ptr<Store>>(const tonus::testing::TemporaryFolder& folder)> make;
};

inline void PrintTo(const StoreMaker& maker, std::ostream* out) { *out << maker.name; }

/// What every store does, real or simulated; store_contract.cpp has the tests.
class StoreContract : public ::testing::TestWithParam<StoreMaker> {
 protected:
  void SetUp() override {
    auto store = GetParam().make(folder_);
    if (!store && store.error().code == ErrorCode::kNotFound) GTEST_SKIP() << store.error().message;
    ASSERT_TRUE(store) << store.error().message;
    store_ = std::move(*store);
  }

  void commit(const Batch& batch) {
    const auto committed = store_->commit(batch);
    ASSERT_TRUE(committed) << committed.error().message;
  }

  std::vector<std::uint64_t> firsts_in(SequenceRange range, const StreamKey& stream = kStream) {
    std::vector<std::uint64_t> firsts;
    const auto visited = store_->visit_blocks({stream, range}, [&](const Block& block) -> Result<void> {
      firsts.push_back(block.first_sequence);
      return {};
    });
    EXPECT_TRUE(visited);
    return firsts;
  }

  std::vector<std::string> texts_of(const MessageQuery& query) {
    std::vector<std::string> texts;
    const auto visited = store_->visit_messages(query, [&](const Message& message) -> Result<void> {
      texts.emplace_back(reinterpret_cast<const char*>(message.payload->data()), message.payload->size());
      return {};
    });
    EXPECT_TRUE(visited);
    return texts;
  }

  tonus::testing::TemporaryFolder folder_;
  std::unique_ptr<Store> store_;
};

}  // namespace tonus::store::testing
