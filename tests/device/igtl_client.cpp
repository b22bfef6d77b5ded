// OpenIGTLink's own client as a program of its own; what it got goes to stdout as text.
//   igtl_client PORT hand NAME COUNT transform|position|quaternion3   sends poses and fingers, prints the last force
//   igtl_client PORT look COUNT                                       prints every point and triangle of COUNT surfaces
#include <igtlClientSocket.h>
#include <igtlPolyDataMessage.h>
#include <igtlPositionMessage.h>
#include <igtlSensorMessage.h>
#include <igtlTransformMessage.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <list>
#include <string>

namespace {

template <class Message>
bool receive_rest(igtl::ClientSocket* socket, igtl::MessageHeader::Pointer header, Message& message) {
  message->SetMessageHeader(header);
  message->AllocatePack();
  if (socket->Receive(message->GetPackBodyPointer(), message->GetPackBodySize()) != message->GetPackBodySize())
    return false;
  return (message->Unpack(1) & igtl::MessageHeader::UNPACK_BODY) != 0;
}

igtl::MessageHeader::Pointer receive_header(igtl::ClientSocket* socket) {
  igtl::MessageHeader::Pointer header = igtl::MessageHeader::New();
  header->InitPack();
  if (socket->Receive(header->GetPackPointer(), header->GetPackSize()) != header->GetPackSize()) return nullptr;
  header->Unpack();
  return header;
}

bool send(igtl::ClientSocket* socket, igtl::MessageBase* message) {
  message->Pack();
  return socket->Send(message->GetPackPointer(), message->GetPackSize()) != 0;
}

/// 100 + k mm, 20, 30; turned by 90 degrees about z.
bool send_pose(igtl::ClientSocket* socket, const char* name, int k, const std::string& kind) {
  const float x = 100.0F + static_cast<float>(k), half = 0.70710678F;
  if (kind == "transform") {
    igtl::TransformMessage::Pointer message = igtl::TransformMessage::New();
    igtl::Matrix4x4 matrix = {{0, -1, 0, x}, {1, 0, 0, 20}, {0, 0, 1, 30}, {0, 0, 0, 1}};
    message->SetDeviceName(name);
    message->SetMatrix(matrix);
    return send(socket, message);
  }
  igtl::PositionMessage::Pointer message = igtl::PositionMessage::New();
  message->SetDeviceName(name);
  if (kind == "quaternion3") message->SetPackType(igtl::PositionMessage::WITH_QUATERNION3);
  message->SetPosition(x, 20, 30);
  message->SetQuaternion(0, 0, half, half);
  return send(socket, message);
}

bool send_fingers(igtl::ClientSocket* socket, const char* name) {
  igtl::SensorMessage::Pointer message = igtl::SensorMessage::New();
  double values[] = {0.25, 3.5, 1, 0, 1, 0};
  message->SetDeviceName(name);
  message->SetLength(6);
  message->SetValue(values);
  return send(socket, message);
}

int hand(igtl::ClientSocket* socket, const char* name, int count, const std::string& kind) {
  for (int k = 0; k < count; ++k) {
    if (!send_pose(socket, name, k, kind) || !send_fingers(socket, name)) return 3;
    usleep(2000);
  }
  double last[6] = {};
  socket->SetReceiveTimeout(400);
  while (true) {
    const igtl::MessageHeader::Pointer header = receive_header(socket);
    if (header.IsNull() || std::strcmp(header->GetDeviceType(), "SENSOR") != 0) break;
    igtl::SensorMessage::Pointer message = igtl::SensorMessage::New();
    if (!receive_rest(socket, header, message) || message->GetLength() != 6) return 4;
    bool shows = false;
    for (unsigned k = 0; k < 6; ++k) shows = shows || message->GetValue(k) != 0;
    for (unsigned k = 0; shows && k < 6; ++k) last[k] = message->GetValue(k);
    if (shows && std::strcmp(header->GetDeviceName(), name) != 0) return 5;
    if (!shows && last[0] != 0) break;  // the loop has let go
  }
  std::printf("force %.17g %.17g %.17g torque %.17g %.17g %.17g\n", last[0], last[1], last[2], last[3], last[4],
              last[5]);
  return 0;
}

int look(igtl::ClientSocket* socket, int count) {
  socket->SetReceiveTimeout(5000);
  for (int k = 0; k < count; ++k) {
    const igtl::MessageHeader::Pointer header = receive_header(socket);
    if (header.IsNull() || std::strcmp(header->GetDeviceType(), "POLYDATA") != 0) return 4;
    igtl::PolyDataMessage::Pointer message = igtl::PolyDataMessage::New();
    if (!receive_rest(socket, header, message)) return 5;
    std::printf("surface %s\n", header->GetDeviceName());
    igtl::PolyDataPointArray::Pointer points = message->GetPoints();
    for (int p = 0; p < points->GetNumberOfPoints(); ++p) {
      float x[3];
      points->GetPoint(static_cast<unsigned>(p), x);
      std::printf("v %a %a %a\n", static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2]));
    }
    igtl::PolyDataCellArray::Pointer cells = message->GetPolygons();
    for (unsigned c = 0; c < cells->GetNumberOfCells(); ++c) {
      std::list<igtlUint32> cell;
      cells->GetCell(c, cell);
      std::printf("f");
      for (const igtlUint32 corner : cell) std::printf(" %u", corner);
      std::printf("\n");
    }
  }
  return 0;
}

}  // namespace

int main(int count, char** words) {
  if (count < 4) return 2;
  igtl::ClientSocket::Pointer socket = igtl::ClientSocket::New();
  if (socket->ConnectToServer("127.0.0.1", std::atoi(words[1])) != 0) return 1;
  const std::string what = words[2];
  const int result = what == "look" ? look(socket, std::atoi(words[3]))
                                    : (count < 6 ? 2 : hand(socket, words[3], std::atoi(words[4]), words[5]));
  socket->CloseSocket();
  return result;
}
