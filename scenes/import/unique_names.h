#pragma once

#include <map>
#include <string>

namespace tessera {

/// Gives out names of one kind, each once: the wish itself, or with "#2" and so on behind it.
class UniqueNames {
 public:
  std::string operator()(const std::string& wish) {
    std::string name = wish;
    while (const int taken = wishes_[name]++) name = wish + "#" + std::to_string(taken + 1);
    return name;
  }

 private:
  std::map<std::string, int> wishes_;
};

}  // namespace tessera
