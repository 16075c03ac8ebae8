#include "written_files.h"

#include <zlib.h>

#include "test.h"

namespace gicube::scene {
namespace {

std::string deflated(const std::string& bytes, int window_bits) {
  z_stream stream{};
  if (deflateInit2(&stream, 9, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY) != Z_OK) throw std::bad_alloc();
  std::string out(deflateBound(&stream, bytes.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int status = deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  if (status != Z_STREAM_END) throw std::runtime_error("deflate");
  return out;
}

}  // namespace

std::string gzip(const std::string& bytes) { return deflated(bytes, MAX_WBITS + 16); }
std::string zlib(const std::string& bytes) { return deflated(bytes, MAX_WBITS); }

std::string read_error(const std::filesystem::path& path, const std::optional<RawLayout>& layout) {
  return message_of<FileError>([&] { read_volume(path, layout); });
}

}  // namespace gicube::scene
