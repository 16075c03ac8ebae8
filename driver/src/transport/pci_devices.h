// The PCI functions of this machine that are GI-Cube boards (gicube-pci, docs/guide/pci.md), as the kernel lists them
// in sysfs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gicube {

struct PciDevice {
  std::string address;  // for example 0000:00:04.0
  bool in_use = false;  // a process has opened it
};

// By address.
std::vector<PciDevice> pci_devices(const std::filesystem::path& sys = "/sys");

// The folder of a function, which may not exist.
std::filesystem::path pci_folder(const std::string& address, const std::filesystem::path& sys = "/sys");

// The kernel driver that the function is bound to; empty: none.
std::string kernel_driver_of(const std::filesystem::path& folder);

// Conditions that must hold before a function can be opened.
struct PciCondition {
  bool holds;
  std::string question, answer;
  std::string advice;  // what to do if it does not hold
};

// In the order in which they are needed, up to the first that does not hold.
std::vector<PciCondition> pci_conditions(const std::string& address, const std::filesystem::path& sys = "/sys");

}  // namespace gicube
