#include "services/store/postgres_link.hpp"
#include "services/store/postgres_store.hpp"

namespace tonus::store {

PostgresStore::PostgresStore(std::unique_ptr<PostgresLink> link) : link_(std::move(link)) {}

PostgresStore::~PostgresStore() = default;

std::string PostgresStore::name() const { return link_->name(); }

Result<std::unique_ptr<PostgresStore>> PostgresStore::open(const std::string& url, Access access) {
  auto link = std::make_unique<PostgresLink>(url, access);
  TONUS_TRY(link->connect());
  return std::unique_ptr<PostgresStore>(new PostgresStore(std::move(link)));
}

}  // namespace tonus::store
