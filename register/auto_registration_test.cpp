#include "register/auto_registration.h"
