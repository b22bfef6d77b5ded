#include "app/staged_folder.h"

#include "calot/base/error.h"
#include "calot/base/files.h"

namespace calot {
namespace fs = std::filesystem;

StagedFolder::StagedFolder(fs::path target) : target_(std::move(target)) {
  if (!target_.has_filename() && target_.has_parent_path()) target_ = target_.parent_path();  // "out/" is "out"
  std::error_code code;
  if (fs::exists(target_, code) && !fs::is_directory(target_, code))
    throw InputError(target_.string(), "exists and is not a folder", "name another folder");
  if (target_.filename() == "." || target_.filename() == "..") target_ = fs::canonical(target_, code);
}

StagedFolder::~StagedFolder() {
  if (folder_.empty()) return;
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
  if (committed_ || made_.empty()) return;
  for (fs::path parent = fs::absolute(target_, ignored).parent_path(); parent.string().size() >= made_.string().size();
       parent = parent.parent_path())
    fs::remove(parent, ignored);  // only those that are empty
}

void StagedFolder::fill(const std::function<void(const fs::path&)>& write, const std::vector<std::string>& files) {
  open();
  try {
    write(folder_);
  } catch (const Error& error) {
    std::string text = error.what();
    const std::size_t place = text.find(folder_.string());
    if (place == std::string::npos) throw;
    throw Error(error.kind(), "", text.replace(place, folder_.string().size(), target_.string()));
  }
  commit(files);
}

const fs::path& StagedFolder::open() {
  std::error_code code;
  const fs::path parent = fs::absolute(target_, code).parent_path();
  for (fs::path missing = parent; !missing.empty() && !fs::exists(missing, code); missing = missing.parent_path())
    made_ = missing;
  folder_ = partial_path(target_);
  fs::create_directories(folder_, code);
  if (code)
    throw FailedError(target_.string(), "can't be made: " + code.message(), "check the folder and its permissions");
  return folder_;
}

void StagedFolder::require_own(const std::string& marker) const {
  std::error_code code;
  if (!fs::is_directory(target_, code) || fs::is_empty(target_, code) || fs::exists(target_ / marker, code)) return;
  throw InputError(target_.string(), "holds other files (and no " + marker + ")",
                   "name a new folder, so that nothing of yours is replaced");
}

void StagedFolder::require_apart(const std::vector<std::string>& files, const std::vector<fs::path>& inputs) const {
  std::error_code code;
  for (const std::string& file : files)
    for (const fs::path& input : inputs)
      if (fs::exists(target_ / file, code) && fs::exists(input, code) && fs::equivalent(target_ / file, input, code))
        throw InputError(input.string(), "would be replaced by the output of the same name", "name another folder");
}

/// Renaming stops at the first file that fails: what can be known to fail is found before the first.
void StagedFolder::check_room(const std::vector<std::string>& files) const {
  std::error_code code;
  for (const std::string& file : files) {
    if (fs::is_directory(target_ / file, code))
      throw FailedError((target_ / file).string(), "is a folder where a file is to be written", "move it away");
    for (fs::path above = fs::path(file).parent_path(); !above.empty(); above = above.parent_path())
      if (fs::exists(target_ / above, code) && !fs::is_directory(target_ / above, code))
        throw FailedError((target_ / above).string(), "is a file where a folder is to be written", "move it away");
  }
}

void StagedFolder::commit(const std::vector<std::string>& files) {
  std::error_code code;
  if (!fs::exists(target_, code)) {
    fs::rename(folder_, target_, code);
    if (code) throw FailedError(target_.string(), "can't be written: " + code.message(), "check the folder");
  } else {
    check_room(files);
    for (const std::string& file : files) {
      fs::create_directories((target_ / file).parent_path(), code);  // the rename says what is wrong
      fs::rename(folder_ / file, target_ / file, code);
      if (code) throw FailedError((target_ / file).string(), "can't be written: " + code.message(), "check the folder");
    }
  }
  committed_ = true;
}

}  // namespace calot
