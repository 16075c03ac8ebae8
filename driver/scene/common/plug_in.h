// Shared objects that are loaded when they are first needed, because they depend on large libraries.
#pragma once

#include <string>

namespace gicube::scene {

// The function of this name in libgicube-NAME.so, loaded with these flags of dlopen(). Null: `error` has the reason.
void* function_in(const std::string& name, const std::string& function, int flags, std::string& error);

}  // namespace gicube::scene
