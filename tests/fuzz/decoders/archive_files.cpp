#include "services/store/sqlite_pages.hpp"
#include "tests/fuzz/decoders/decoder.hpp"
#include "tests/fuzz/target.hpp"

namespace tonus::fuzz {

void read_sqlite_pages(std::span<const std::byte> input) {
  const std::string path = scratch_folder() + "/damaged.sqlite";
  write_bytes(path, Bytes(input.begin(), input.end()));
  auto pages = store::SqlitePages::open(path);
  require_message(pages);
  if (!pages) return;
  std::uint64_t rows = 0;
  const auto visited = pages->visit_rows([&](const store::SqliteRow& row, const store::SqliteCell& cell) {
    if (++rows > 8) return;
    const auto again = pages->read(cell);
    require(again && again->rowid == row.rowid && again->values.size() == row.values.size(),
            "a row that was found is found again");
  });
  require_message(visited);
}

/// The archive's first pages, and some of its data.
std::vector<Bytes> sqlite_pages_seeds() {
  const std::string path = scratch_folder() + "/seed.sqlite";
  require(make_store(path).has_value(), "an archive can be made");
  const Bytes whole = read_bytes(path);
  const auto part = [&](std::size_t first, std::size_t count) {
    first = std::min(first, whole.size());
    const auto begin = whole.begin() + static_cast<std::ptrdiff_t>(first);
    return Bytes(begin, begin + static_cast<std::ptrdiff_t>(std::min(count, whole.size() - first)));
  };
  return {part(0, 8192), part(4096, 8192), part(whole.size() / 2 / 4096 * 4096, 4096)};
}

}  // namespace tonus::fuzz
