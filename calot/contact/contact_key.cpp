#include "calot/contact/friction.h"
#include "calot/contact/tissue_contact.h"
