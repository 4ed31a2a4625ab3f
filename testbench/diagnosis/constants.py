"""The numbers of the diagnosis that nothing else determines, each with its reason."""

ETA = 0.05  # knowledge in a sample of white residual: every model is a little wrong, and samples share its error
INDEPENDENT = 30  # pieces of a recording whose errors of a law are independent
LEAST_MISFIT = 1.25  # noise floors: no law of a catalogue is nearer to a sensor, and instruments have slow noise, too
INEXACT = 0.05  # of what a law explains: so far is it from the sensor's own at least, however low the noise
NOISE_SPREAD = (
    0.3  # of ln(what a complete model leaves over the least misfit): how far the base is from other sensors
)
MOST_LEFT = 100.0  # least misfits that a model leaves at most, if something else is missing
PRIOR_NOTHING = 0.5  # before seeing data, that nothing is missing
PRIOR_UNKNOWN = 0.1  # before seeing data, that what is missing is in no catalogue
GRID_HZ = 12.5  # grid of the comparison: quicker than the motion, slower than most samplings
SAMPLES = 9_000  # samples of one channel that enter the normal equations; longer recordings are thinned
REFITS, SETTLED = 6, 4  # mechanisms refitted in one round of the search; refits that are carried to their end
ITERATIONS = 14  # steps of a refit at most
ROUNDS = 4  # effects at most
