#include "client/prepare.hpp"

#include "client/interrupt.hpp"
#include "common/base/error.hpp"

namespace tessera::client {

assets::Bundle bundle_of(const std::vector<scene::UsedFile>& files) {
  assets::Bundle bundle;
  bundle.scene = files.front().path;
  for (const scene::UsedFile& used : files) {
    throw_if_interrupted();
    bundle.files[used.path] = {digest_of_file(used.file), std::filesystem::file_size(used.file)};
  }
  assets::check(bundle);
  return bundle;
}

PreparedJob prepare(const JobOptions& options) {
  scene::LoadedScene loaded;
  try {
    loaded = scene::load_scene(options.scene);
  } catch (const Error& error) {
    // A scene that is not there was named wrongly: the command's input, not something that it did,
    // is at fault.
    if (error.kind() == ErrorKind::not_found)
      throw Error(ErrorKind::bad_input, error.message(), error.place());
    throw;
  }
  throw_if_interrupted();
  PreparedJob out;
  out.spec = job_from(loaded.scene, options,
                      Digest{});  // what is wrong with it is said before files are hashed
  out.bundle = bundle_of(loaded.files);
  out.spec.bundle = assets::digest_of_bundle(out.bundle);
  out.files = std::move(loaded.files);
  return out;
}

}  // namespace tessera::client
