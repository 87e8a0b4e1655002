#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "services/core/progress.hpp"
#include "services/store/store.hpp"

namespace tonus::store {

/// Which sessions a copy takes.
struct CopySelection {
  /// Empty: every session. Otherwise these, with what was in force when they began, and nothing that belongs
  /// to no session.
  std::vector<Id> only;

  /// These are left out. What was in force when a copied session began is copied, whichever session it came
  /// in.
  std::vector<Id> without;
};

/// What a copy took.
struct CopyCount {
  std::uint64_t sessions = 0;
  std::uint64_t trials = 0;
  std::uint64_t blocks = 0;
  std::uint64_t messages = 0;
  std::uint64_t samples = 0;
};

/// Copies sessions from one store to an empty one of any kind, payloads byte for byte with their checksums,
/// which are checked on the way. `from` may be written meanwhile: what it certifies at the call is in the
/// copy. Where sessions are chosen by `only`, the copy states coverage of what it holds; else the source's,
/// since what was removed on purpose is not to be sent again.
///
/// kAlreadyExists: `to` holds something. kDataLoss: a payload of `from` is damaged (`tonus recover` copies
/// what is left). On any error `to` holds a part, without coverage and certificates; the caller removes it.
[[nodiscard]] Result<CopyCount> copy_store(Store& from, Store& to, const CopySelection& selection,
                                           const Progress& progress);

/// copy_store() to a new file that is there whole and read back, or not at all. kAlreadyExists: `path`
/// exists. kIo: the disk.
[[nodiscard]] Result<CopyCount> copy_to_sqlite(Store& from, const std::string& path,
                                               const CopySelection& selection, const Progress& progress);

/// Removes sessions from an SQLite archive that no program writes: copies everything else to a new file,
/// reads it back, and puts it in the old one's place in one step; before that nothing is changed. Errors as
/// SqliteStore::open() and copy_store(); kIo: no room for the copy.
[[nodiscard]] Result<CopyCount> prune_sqlite(const std::string& path, const std::vector<Id>& sessions,
                                             const Progress& progress);

}  // namespace tonus::store
