#include "calot/contact/friction.h"

#include <gtest/gtest.h>
