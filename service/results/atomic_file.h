// Files that appear whole or not at all.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace caustic::service {

/// Temporary names end so; no file that counts does.
constexpr std::string_view kTemporarySuffix = ".tmp";

/// Writes and syncs a temporary file beside `path`, gives it its name and syncs the folder. A file
/// that is there already stays, and false is returned. Throws std::system_error, with the temporary
/// file removed.
bool create_file(const std::filesystem::path& path, std::string_view bytes);

/// The same, but what is there gives way.
void replace_file(const std::filesystem::path& path, std::string_view bytes);

/// Removes temporary files of this folder whose writers are gone. Those at work hold a lock.
void sweep_temporaries(const std::filesystem::path& folder);

/// Nothing if there is no such file; throws std::system_error if it cannot be read.
std::optional<std::string> read_file(const std::filesystem::path& path);

}  // namespace caustic::service
