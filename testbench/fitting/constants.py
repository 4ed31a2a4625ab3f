"""The numbers of the diagnosis that nothing else determines, each with its reason.

First what is assumed of sensors and their laws, then how much work a search may do.
"""

# What is assumed
ALIKE_S = 1.6  # residuals of a model resemble each other for so long: closer samples count as one
INDEPENDENT = 120  # pieces of a recording whose errors of a law are independent, about two a stroke
IN_LAST_FIT = 240  # pieces at most in the last fit of a model: parameters are known better than which model is right
LEAST_MISFIT = 1.25  # noise floors: no law of a catalogue is nearer to a sensor, and instruments have slow noise, too
LAW_ERROR = 0.2  # of what a law explains: how far the laws of the catalogue usually are from those of a sensor
LAW_SPREAD = 0.4  # of ln(that error): laws of real materials err by a third, those of simulated ones by a tenth
INEXACT = 0.05  # the same at least, however low the noise: what is nearer is no merit
NOISE_SPREAD = 0.15  # of ln(what a complete model leaves / least misfit): how far the base is from other sensors
MOST_LEFT = 100.0  # least misfits that a model leaves at most, if something else is missing
PRIOR_NOTHING = 0.5  # before seeing data, that nothing is missing
PRIOR_UNKNOWN = 0.25  # before seeing data, that what is missing, if anything is, is in no catalogue
EVIDENCE_ERROR = 2.0  # nats, standard deviation: of an integral by its peak, and of where a fit ends
MISLED = 0.15  # share of sensors, of kinds not simulated here, for which evidence that seemed sure was wrong

# How much work
GRID_HZ = 12.5  # grid of the comparison: quicker than the motion, slower than most samplings
GRID_POINTS = 15_000  # at most on that grid: coarser for recordings of more than 20 min, whose turns it keeps
FINER = 4  # times as many grid points for the last fits of the models that were chosen
SAMPLES = 2_400  # samples of one channel that enter the normal equations; longer recordings are thinned
BEAM = 2  # of the best that go on: sets of base laws, mechanisms by several laws, first steps where none has a name
BENDING = 4  # mechanisms refitted in a round of those that show beside bases that bend
STIFF = BENDING  # and as many of those that show beside bases that do not
LAWS = 3  # of a mechanism that are refitted at a time; of one that is not among the best, one is carried to its end
ITERATIONS = 14  # steps of a refit at most
REFITS = 3  # at most, one after the other, where a law is carried to its end
ROUNDS = 4  # effects at most
