#pragma once

#include <functional>
#include <gtest/gtest.h>
#include <string>

#include "services/store/open_store.hpp"
#include "tests/support/made_up_session/made_up_session.hpp"
#include "tests/support/temporary_folder.hpp"

namespace tonus::testing {

/// An archive with one made-up session, closed in an orderly way.
class ArchiveFile {
 public:
  explicit ArchiveFile(made_up::SessionRecipe recipe = made_up::unloaded_session()) {
    auto store = store::open_store_for_writing(path());
    EXPECT_TRUE(store) << store.error().message;
    record_ = made_up::put_session(**store, std::move(recipe));
  }

  [[nodiscard]] std::string path() const { return (folder_ / "archive.sqlite").string(); }
  [[nodiscard]] const store::SessionRecord& record() const { return record_; }

 private:
  TemporaryFolder folder_;
  store::SessionRecord record_;
};

}  // namespace tonus::testing
