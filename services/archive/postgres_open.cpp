#include "services/archive/postgres_link.hpp"
#include "services/archive/postgres_store.hpp"

namespace tonus::archive {

PostgresStore::PostgresStore(std::unique_ptr<PostgresLink> link) : link_(std::move(link)) {}

PostgresStore::~PostgresStore() = default;

std::string PostgresStore::name() const { return link_->name(); }

Result<std::unique_ptr<PostgresStore>> PostgresStore::open(const std::string& url, Access access) {
  auto link = std::make_unique<PostgresLink>(url, access);
  if (auto connected = link->connect(); !connected) return connected.error();
  return std::unique_ptr<PostgresStore>(new PostgresStore(std::move(link)));
}

}  // namespace tonus::archive
