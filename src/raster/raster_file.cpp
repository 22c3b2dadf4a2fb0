// placeholder until the sampling is in
