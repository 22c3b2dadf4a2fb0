#pragma once

#include <string>

#include "io/resources.h"

namespace tellurion::io {

bool isFileUrl(const std::string& url);

/// The bytes of a file: URL of this machine; null: there is no such file. Reads at once, on the caller's thread.
Result<std::shared_ptr<const Resource>> readLocalFile(const ResourceRequest& request);

}  // namespace tellurion::io
