#include "services/bus/cyclonedds/cdr_sertype.hpp"

#include <dds/dds.h>

#include "services/bus/cyclonedds/cdr_serdata.hpp"

namespace tonus::bus {
namespace {

void free_sertype(ddsi_sertype* type) {
  ddsi_sertype_fini(type);
  delete static_cast<CdrSertype*>(type);
}

// Called for two types of one name and these same operations, which leaves nothing to compare.
bool is_equal(const ddsi_sertype*, const ddsi_sertype*) { return true; }
std::uint32_t hash(const ddsi_sertype*) { return 0; }

ddsi_sertype_ops make_ops() {
  ddsi_sertype_ops ops{};
  ops.version = ddsi_sertype_v0;
  ops.free = free_sertype;
  ops.equal = is_equal;
  ops.hash = hash;
  return ops;
}

const ddsi_sertype_ops* cdr_sertype_ops() {
  static const ddsi_sertype_ops ops = make_ops();
  return &ops;
}

}  // namespace

CdrSertype::CdrSertype(const std::string& name) : ddsi_sertype{} {
  ddsi_sertype_init_flags(this, name.c_str(), cdr_sertype_ops(), cdr_serdata_ops(), 0);  // 0: with a key
  allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
}

}  // namespace tonus::bus
