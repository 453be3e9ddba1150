"""Claims about the outcome of a run, one module for each kind. Importing this package registers all of them."""

from stackdsl.language.claims import carried as carried
from stackdsl.language.claims import collapses as collapses
from stackdsl.language.claims import displaced as displaced
from stackdsl.language.claims import drift as drift
from stackdsl.language.claims import energy as energy
from stackdsl.language.claims import falls as falls
from stackdsl.language.claims import height as height
from stackdsl.language.claims import lands as lands
from stackdsl.language.claims import leaves as leaves
from stackdsl.language.claims import margin as margin
from stackdsl.language.claims import pallet_limits as pallet_limits
from stackdsl.language.claims import penetration as penetration
from stackdsl.language.claims import pivots as pivots
from stackdsl.language.claims import protocol as protocol
from stackdsl.language.claims import rests_on as rests_on
from stackdsl.language.claims import stands as stands
from stackdsl.language.claims import sway as sway
from stackdsl.language.claims import untouched as untouched
from stackdsl.language.claims import verdict as verdict
