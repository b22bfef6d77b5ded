#include "app/view_arguments.h"
namespace calot {
void view_in_window(const ViewArguments&) {}
}  // namespace calot
