#include "asic/sorter/policies/policy.h"

#include <stdexcept>
#include <string>

#include "asic/sorter/policies/longest_wait.h"
#include "asic/sorter/policies/most_contribution.h"
#include "asic/sorter/policies/most_rays.h"

namespace gicube::emu {

ImportanceOf importance_of(v1::QueuePolicy policy) {
  switch (policy) {
    case v1::most_rays: return most_rays;
    case v1::most_contribution: return most_contribution;
    case v1::longest_wait: return longest_wait;
    case v1::POLICY_UNSPECIFIED: break;
  }
  throw std::invalid_argument("sorter.policy: expected a policy of asic/sorter/policies, got " +
                              std::to_string(static_cast<int>(policy)));
}

}  // namespace gicube::emu
