"""Safe bounds of response times, histories and chains, by response-time analysis: for systems of any size."""
