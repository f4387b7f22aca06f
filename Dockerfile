FROM python:3.13-slim
COPY . /source
RUN pip install --no-cache-dir /source && rm -r /source
RUN useradd --create-home user
USER user
WORKDIR /home/user
ENTRYPOINT ["irg"]
