// replaced by geo helper
