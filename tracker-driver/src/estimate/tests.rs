mod prediction;
