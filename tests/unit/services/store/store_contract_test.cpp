#include "tests/unit/services/store/store_contract.hpp"

#include "services/store/memory_store.hpp"
#include "services/store/sqlite_store.hpp"

namespace tonus::store::testing {
namespace {

Result<std::unique_ptr<Store>> memory(const tonus::testing::TemporaryFolder&) {
  return std::unique_ptr<Store>(std::make_unique<MemoryStore>());
}

Result<std::unique_ptr<Store>> sqlite(const tonus::testing::TemporaryFolder& folder) {
  auto store = SqliteStore::open(folder / "study.sqlite", SqliteStore::Access::kWrite);
  if (!store) return store.error();
  return std::unique_ptr<Store>(std::move(*store));
}

INSTANTIATE_TEST_SUITE_P(Stores, StoreContract,
                         ::testing::Values(StoreMaker{"memory", memory}, StoreMaker{"sqlite", sqlite}),
                         [](const auto& made) { return made.param.name; });

}  // namespace
}  // namespace tonus::store::testing
