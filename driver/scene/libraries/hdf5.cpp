// libgicube-hdf5.so: data sets of HDF5.
#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <utility>

#include "scene/libraries/each_library.h"

namespace gicube::scene {
namespace {

constexpr std::uint64_t kMaxRatio = 1032;                    // zlib's technical notes
constexpr std::size_t kMaxListed = 32, kMaxObjects = 65536;  // chosen

// An identifier of the library, with the function that closes it.
class Id {
 public:
  Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Id() {
    if (id_ >= 0) close_(id_);
  }
  Id(const Id&) = delete;
  Id& operator=(const Id&) = delete;
  operator hid_t() const { return id_; }  // NOLINT(*-explicit-*): as the library's functions take it
  bool good() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

struct Found {
  std::string path;
  std::vector<hsize_t> sizes;
};

std::vector<hsize_t> sizes_of(hid_t data_set) {
  const Id space(H5Dget_space(data_set), H5Sclose);
  const int rank = space.good() ? H5Sget_simple_extent_ndims(space) : 0;
  std::vector<hsize_t> sizes(static_cast<std::size_t>(std::max(rank, 0)));
  if (rank > 0) H5Sget_simple_extent_dims(space, sizes.data(), nullptr);
  return sizes;
}

// All data sets with axes.
struct Search {
  std::vector<Found> found;
  std::size_t objects = 0;
};

herr_t visit(hid_t root, const char* name, const H5O_info_t* info, void* search) {
  auto& all = *static_cast<Search*>(search);
  if (++all.objects > kMaxObjects) return 1;
  if (info->type != H5O_TYPE_DATASET) return 0;
  const Id data_set(H5Dopen2(root, name, H5P_DEFAULT), H5Dclose);
  if (!data_set.good()) return 0;
  std::vector<hsize_t> sizes = sizes_of(data_set);
  if (!sizes.empty()) all.found.push_back({"/" + std::string(name), std::move(sizes)});
  return 0;
}

// A text attribute, as in NeXus; empty if there is none.
std::string attribute(hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) return {};
  const Id attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  const Id type(H5Aget_type(attribute), H5Tclose);
  if (!type.good() || H5Tget_class(type) != H5T_STRING) return {};
  if (H5Tis_variable_str(type) > 0) {
    char* text = nullptr;
    const Id memory(H5Tcopy(type), H5Tclose);
    if (H5Aread(attribute, memory, static_cast<void*>(&text)) < 0 || text == nullptr) return {};
    std::string out = text;
    H5free_memory(text);
    return out;
  }
  const std::size_t bytes = H5Tget_size(type);
  const Id space(H5Aget_space(attribute), H5Sclose);
  if (bytes > 4096 || H5Sget_simple_extent_npoints(space) != 1) return {};
  std::string out(bytes, '\0');
  if (H5Aread(attribute, type, out.data()) < 0) return {};
  return out.substr(0, out.find('\0'));
}

// The default data set of NeXus: attributes "default" lead to the group whose "signal" names it.
std::string nexus_default(hid_t file) {
  std::string at = "/";
  for (int depth = 0; depth < 4; ++depth) {
    const Id group(H5Oopen(file, at.c_str(), H5P_DEFAULT), H5Oclose);
    if (!group.good()) return {};
    if (const std::string signal = attribute(group, "signal"); !signal.empty())
      return (at == "/" ? at : at + "/") + signal;
    const std::string next = attribute(group, "default");
    if (next.empty()) return {};
    at += (at == "/" ? "" : "/") + next;
  }
  return {};
}

Found choose(const std::filesystem::path& file, hid_t id, const std::string& part) {
  Search search;
  H5Ovisit2(id, H5_INDEX_NAME, H5_ITER_NATIVE, visit, &search, H5O_INFO_BASIC);
  const auto named = [&](const std::string& path) { return std::ranges::find(search.found, path, &Found::path); };
  if (const auto found = named(part.starts_with('/') ? part : "/" + part); found != search.found.end()) {
    // Data of fewer axes are a row or a plane.
    if (found->sizes.size() < 3) found->sizes.insert(found->sizes.begin(), 3 - found->sizes.size(), 1);
    return *found;
  }
  std::erase_if(search.found, [](const Found& each) { return each.sizes.size() < 3; });
  std::string list;
  for (std::size_t i = 0; i < search.found.size() && i < kMaxListed; ++i)
    list += fmt::format("{}{} ({})", i > 0 ? ", " : "", search.found[i].path, fmt::join(search.found[i].sizes, " x "));
  if (!part.empty()) fail(file, "part", "a data set: " + list, '"' + part + '"');
  if (search.found.size() == 1) return search.found.front();
  // In DXchange, /exchange/data has the projections or a reconstruction.
  for (const std::string& path : {nexus_default(id), std::string("/exchange/data"), std::string("/entry/data/data")}) {
    if (const auto found = named(path); found != search.found.end()) return *found;
  }
  fail(file, "part", search.found.empty() ? "a data set of three axes" : "one of the data sets " + list, "none");
}

using Type = std::pair<StoredType, hid_t>;

Type type_of(const std::filesystem::path& file, const std::string& path, hid_t data_set) {
  const Id type(H5Dget_type(data_set), H5Tclose);
  const H5T_class_t kind = type.good() ? H5Tget_class(type) : H5T_NO_CLASS;
  const std::size_t bytes = type.good() ? H5Tget_size(type) : 0;
  const bool sign = H5Tget_sign(type) == H5T_SGN_2;
  if (kind == H5T_INTEGER || kind == H5T_ENUM) {  // h5py's bool is an enumeration of int8
    if (bytes == 1) return sign ? Type{StoredType::kInt8, H5T_NATIVE_INT8} : Type{StoredType::kUint8, H5T_NATIVE_UINT8};
    if (bytes == 2)
      return sign ? Type{StoredType::kInt16, H5T_NATIVE_INT16} : Type{StoredType::kUint16, H5T_NATIVE_UINT16};
    if (bytes == 4)
      return sign ? Type{StoredType::kInt32, H5T_NATIVE_INT32} : Type{StoredType::kUint32, H5T_NATIVE_UINT32};
    if (bytes == 8)
      return sign ? Type{StoredType::kInt64, H5T_NATIVE_INT64} : Type{StoredType::kUint64, H5T_NATIVE_UINT64};
  }
  if (kind == H5T_FLOAT && bytes <= 4) return {StoredType::kFloat32, H5T_NATIVE_FLOAT};  // half floats too
  if (kind == H5T_FLOAT && bytes == 8) return {StoredType::kFloat64, H5T_NATIVE_DOUBLE};
  fail(file, path, "integers or floats of at most 64 bits",
       fmt::format("class {} of {} bytes", static_cast<int>(kind), bytes));
}

// The attribute element_size_um of ilastik and Fiji: z, y, x.
Vec3 spacing_of(const std::filesystem::path& file, hid_t data_set) {
  const char* const name = "element_size_um";
  if (H5Aexists(data_set, name) <= 0) return {1, 1, 1};
  const Id attribute(H5Aopen(data_set, name, H5P_DEFAULT), H5Aclose);
  const Id space(H5Aget_space(attribute), H5Sclose);
  std::array<double, 3> zyx{};
  if (H5Sget_simple_extent_npoints(space) != 3 || H5Aread(attribute, H5T_NATIVE_DOUBLE, zyx.data()) < 0)
    fail(file, name, "three numbers, z y x", "others");
  return {zyx[2], zyx[1], zyx[0]};
}

LibraryVolume read_data_set(const std::filesystem::path& file, const std::string& part) {
  const Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  const Id opened(H5Fopen(file.c_str(), H5F_ACC_RDONLY, access), H5Fclose);
  if (!opened.good()) fail(file, "file", "an HDF5 file that the library can open", "one that is damaged or written to");
  const Found found = choose(file, opened, part);
  const Id data_set(H5Dopen2(opened, found.path.c_str(), H5P_DEFAULT), H5Dclose);
  if (!data_set.good()) fail(file, found.path, "a data set", "a damaged one");
  LibraryVolume out;
  std::size_t others = found.sizes.size() - 3;
  for (std::size_t i = 0; i < others; ++i) {
    if (found.sizes[i] != 1)
      fail(file, found.path, "three axes, any before them of 1", fmt::format("{}", fmt::join(found.sizes, " x ")));
  }
  for (std::size_t i = 0; i < 3; ++i)
    out.layout.dims[i] = static_cast<int>(std::min<hsize_t>(found.sizes[others + 2 - i], kMaxFileDim + 1));
  const auto [stored, memory] = type_of(file, found.path, data_set);
  out.layout.type = stored;
  const std::size_t sample = with_sample(stored, [](auto s) { return sizeof s; });
  const auto bytes = sane_bytes(out.layout, std::max(sample, sizeof(float)));
  if (!bytes)
    fail(file, found.path, fmt::format("1..{} voxels a side, {} bytes", kMaxFileDim, kMaxVolumeBytes),
         fmt::format("{}", fmt::join(found.sizes, " x ")));
  // External files would be read with the rights of this user.
  const Id created(H5Dget_create_plist(data_set), H5Pclose);
  const H5D_layout_t layout = H5Pget_layout(created);
  if (layout == H5D_VIRTUAL || H5Pget_external_count(created) > 0)
    fail(file, found.path, "samples in this file", "a virtual data set, or external files");
  const int filters = H5Pget_nfilters(created);
  const std::size_t all = *bytes / std::max(sample, sizeof(float)) * sample;
  const std::uint64_t in_file = H5Dget_storage_size(data_set);
  const Id type(H5Dget_type(data_set), H5Tclose);
  const std::size_t stored_bytes = all / sample * H5Tget_size(type);  // half floats have half as many
  if (in_file < stored_bytes / (filters > 0 ? kMaxRatio : 1))
    fail(file, found.path, fmt::format("{} bytes of samples", stored_bytes),
         fmt::format("{} in the file (truncated, or never written)", in_file));
  for (int i = 0; i < filters; ++i) {
    unsigned flags = 0, config = 0;
    std::size_t values = 0;
    std::array<char, 64> name{};
    const H5Z_filter_t filter =
        H5Pget_filter2(created, static_cast<unsigned>(i), &flags, &values, nullptr, name.size(), name.data(), &config);
    if (filter < 0 || H5Zfilter_avail(filter) <= 0)
      fail(file, found.path, "a compression that this HDF5 has (deflate, szip, shuffle)",
           fmt::format("{} \"{}\"", filter, name.data()));
  }
  out.layout.spacing = spacing_of(file, data_set);
  allow_time_for(all);
  out.samples.resize(all);
  if (H5Dread(data_set, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, out.samples.data()) < 0)
    fail(file, found.path, "whole samples", "damaged ones");
  return out;
}

void start() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

}  // namespace
}  // namespace gicube::scene

extern "C" __attribute__((visibility("default"))) const gicube::scene::VolumeLibrary* gicube_hdf5() {
  using namespace gicube::scene;
  static const EachLibrary library("HDF5", start, read_data_set);
  return &library;
}
