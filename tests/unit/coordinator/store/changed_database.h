#pragma once

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <filesystem>
#include <string>

namespace tessera {

/// Runs statements on a database that nobody has open, as damage or another version would leave it.
inline void change(const std::filesystem::path& file, const std::string& statements) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  char* failure = nullptr;
  EXPECT_EQ(sqlite3_exec(database, statements.c_str(), nullptr, nullptr, &failure), SQLITE_OK)
      << failure;
  sqlite3_free(failure);
  sqlite3_close(database);
}

}  // namespace tessera
